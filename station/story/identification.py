"""The result of the pipeline for one release."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.free_decay import FreeDecay
from identify.preprocessing.alignment import Alignment
from identify.preprocessing.release import Release
from identify.restoring_force.restoring_force import RestoringForceResult
from identify.wavelet.wavelet import WaveletResult
from station.story.adequacy import Adequacy
from station.story.engineering_values import Weighing


@dataclass(frozen=True, eq=False)
class Identification:
    """Everything that was identified in one release.

    `decay` is the release as it was recorded, with the noise of each channel; `aligned` the same with the
    displacement moved by the lag (`decay` itself where there was nothing to align). A result that could
    not be had is None, and `refusals` says why under the step's name. `adequacy` is whether the identified model explains
    the record, None where that was not asked or (under "adequacy" in `refusals`) not to be had.
    """

    decay: FreeDecay
    release: Release
    alignment: Alignment | None
    aligned: FreeDecay
    wavelet: WaveletResult | None
    restoring_force: RestoringForceResult | None
    refusals: dict[str, str]
    adequacy: Adequacy | None = None

    @property
    def weighing(self) -> Weighing:
        """What puts the mass into forces and strengths."""
        return Weighing(self.decay.mass, self.decay.mass_std, self.decay.unit)

    @property
    def lost_samples(self) -> int:
        """How many samples were lost."""
        return 0 if self.decay.valid is None else int((~self.decay.valid).sum())

    @property
    def amplitude(self) -> float | None:
        """How far the mass was from its rest at the release, m or rad, or None.

        Signed where it was held away and the displacement was measured: its mean before the release less its
        mean over the last tenth of the record. Otherwise the envelope at the start of the ridge.
        """
        displacement, rest = self.decay.displacement, self.release.rest
        if self.release.kind == "displaced" and displacement is not None and rest[1] > rest[0]:
            kept = self.decay.known
            held = displacement[rest[0] : rest[1]][kept[rest[0] : rest[1]]]
            tail = slice(len(displacement) - len(displacement) // 10, None)
            if len(held) and kept[tail].any():
                return float(np.mean(held) - np.mean(displacement[tail][kept[tail]]))
        if self.wavelet is not None and len(self.wavelet.envelope):
            return float(self.wavelet.envelope[0])
        return None

    def rebuilt_decay(self, found: WaveletResult) -> tuple[Array, Array]:
        """Return the measured channel of the wavelet on its times, and the same rebuilt from the parameters, SI."""
        measured = np.asarray(getattr(self.aligned, found.channel))
        index = np.clip(np.round(found.time * self.decay.rate).astype(int), 0, len(measured) - 1)
        offset = float(np.median(measured[index] - found.reconstruction))
        return measured[index], found.reconstruction + offset
