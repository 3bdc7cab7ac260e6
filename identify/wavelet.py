"""The wavelet identification: envelope and instantaneous frequency on the Morlet ridge, eqs. (5)-(12)."""

from dataclasses import dataclass

from identify.arrays import Array
from identify.estimate import Estimate


@dataclass(frozen=True, eq=False)
class WaveletResult:
    """What the envelope and the instantaneous frequency say.

    `stiffness` is K (N/m with a mass, 1/s^2 without); `damping` holds mu_i per unit mass by order
    i = 0..`order`; `stiffness_by_order` the odd orders (1, 3, 5) from the backbone. `mse_percent_by_order` is the misfit of the
    envelope for orders 0..max (fig. 3a); `reason` says why `order` was chosen. Arrays on the ridge, shape
    (n,): `time` (s, on the record's clock), `envelope`, `envelope_fit`, `frequency` (Hz), `trusted` (False near the ends).
    `reconstruction` is the decay rebuilt from the parameters on `time`. `scalogram` (frequencies, times) is
    the modulus on `scalogram_frequency` (Hz) and `scalogram_time` (s). `backbone_amplitude` and
    `backbone_frequency` are the backbone; `hilbert_envelope` is the older reference on `time`.
    """

    stiffness: Estimate
    stiffness_by_order: dict[int, Estimate]
    damping: tuple[Estimate, ...]
    order: int
    reason: str
    mse_percent_by_order: tuple[float, ...]
    channel: str
    time: Array
    envelope: Array
    envelope_fit: Array
    frequency: Array
    trusted: Array
    reconstruction: Array
    scalogram: Array
    scalogram_frequency: Array
    scalogram_time: Array
    backbone_amplitude: Array
    backbone_frequency: Array
    hilbert_envelope: Array
