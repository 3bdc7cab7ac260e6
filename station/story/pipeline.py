"""The whole analysis from a recording to the ladder, one function a step; each takes the results of the last one.

- `identify`: recording -> release, noise, alignment, wavelet, restoring force
- `adequacy`: prepared decay, both methods -> the judgement on the model that they identified (station.story.adequacy)
- `prepare_session`: session -> a release that can be fitted (station.story.preparation)
- `compare`: prepared decay, model -> the fitted model, and where it fails
- `identify.diagnosis.diagnose.diagnose`: prepared decays, model -> what the model lacks
- `identify.diagnosis.diagnose.refine`: prepared decay, model -> the ladder: the error, step by step, as effects are added
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from daq.recording import Recording
from identify.arrays import Array
from identify.comparison.compare import Comparison, compare_fitted as compare_baseline
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, fit_baseline
from identify.fitting.initial_values import initial_values
from identify.fitting.model_error import ModelError, errors_of
from identify.fitting.prediction import predict
from identify.fitting.segments import segments_of
from identify.free_decay import FreeDecay
from identify.model.model import Model
from identify.preprocessing.aligned_decay import AlignedDecay
from identify.preprocessing.alignment import Alignment
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.preprocessing.release import Release
from identify.residual import residual_words
from identify.restoring_force.restoring_force import RestoringForceResult, identify_restoring_force
from identify.wavelet.wavelet import STIFFNESS_ORDERS, WaveletResult, identify_wavelet
from station.story.adequacy import Adequacy, Method, needed_orders
from station.story.engineering_values import Weighing
from station.story.preparation import Options, locate

Value = TypeVar("Value")
Progress = Callable[[str], None]

_BACKBONE = set(STIFFNESS_ORDERS[-1])
"""Orders of stiffness that the backbone shows; even ones leave it straight."""

_ROUNDS = 4
"""An order that one method takes over may make the other need one more."""


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
    def methods(self) -> tuple[Method, ...]:
        """The results of the methods that found something."""
        return tuple(method for method in (self.wavelet, self.restoring_force) if method is not None)

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


@dataclass(frozen=True, eq=False)
class KnownModel:
    """A model, with its name in `words`; `remark` says why it is not another that one might expect.

    `values` are those to fit from, by "effect.parameter" (none: from the data), `states` the internal states at the start
    of the one release it was fitted to, `expressions` the operator's own effects.
    """

    model: Model
    words: str = "the usual model"
    values: dict[str, float] = field(default_factory=dict)
    expressions: tuple[str, ...] = ()
    states: dict[str, float] = field(default_factory=dict)
    remark: str = ""

    def start(self, decays: tuple[PreparedDecay, ...]) -> dict[str, float] | None:
        """Find where a fit to some releases begins, by unknown's name: these values, the releases' own from their motions.

        None where the data say all.
        """
        if not self.values:
            return None
        start = initial_values(decays, self.model, self.values)
        for term in self.model.terms:
            for parameter in term.free:
                id = term.parameter(parameter.name)
                if str(id) not in self.values:
                    continue
                if not parameter.of_release:
                    count = 1 if term.is_force else len(decays)
                    start |= {str(id.of_release(i, count)): self.values[str(id)] for i in range(count)}
        return start | self._of_releases(decays) | (self.states if len(decays) == 1 else {})

    def _of_releases(self, decays: tuple[PreparedDecay, ...]) -> dict[str, float]:
        """Find what each release has of its own of a force by a fit to it, all other values held."""
        own = [(term, p) for term in self.model.forces for p in term.free if p.of_release]
        found: dict[str, float] = {}
        for i, decay in enumerate(decays if own else ()):
            seen = predict(self.model, self.values, decay).values
            found |= {
                str(term.in_release(p, i, len(decays))): seen[str(term.parameter(p.name))] for term, p in own
            }
        return found


@dataclass(frozen=True, eq=False)
class Compared:
    """A model as fitted to the session `name`, and where it fails; `words` say which model it is, `remark` why it
    is not another.

    `judged` is the fit by which the model is judged, as everywhere: that of the pieces of a long record, in which the
    phase drifts by more than forces move it; of a short one `baseline` itself, one free run over the whole record.
    """

    name: str
    baseline: Baseline
    comparison: Comparison
    judged: Baseline
    words: str
    remark: str

    @property
    def error(self) -> ModelError:
        """The three errors by which the model is judged."""
        return errors_of(self.judged)

    @property
    def pieces(self) -> int:
        """In how many pieces the record is judged."""
        return len(self.judged.decays)

    @property
    def left(self) -> str:
        """What the model leaves, in words."""
        above = None if self.judged.at_floor else self.error.floor_std
        return residual_words(self.error.motion_percent, self.error.chi_square, above)

    @property
    def one_run(self) -> str:
        """The residual of a long record simulated in one piece, and why it is larger; "" for a short record."""
        if self.pieces < 2:
            return ""
        seen = self.comparison
        return (
            f"The record is long: it is judged in {self.pieces} pieces that share the physics. In one run over "
            f"{seen.horizon_cycles:.0f} cycles the same model leaves {residual_words(seen.motion_error, seen.chi_square)}, "
            "because the phase may drift with clock and temperature. The places and cycles below are those of that run."
        )


def silent(*said: object) -> None:
    """Report no progress."""


def identify(recording: Recording, options: Options, found: AlignedDecay | None = None) -> Identification:
    """Identify one recording with one release; a step that cannot be done says why, and the others still run.

    `found` is what `locate` returns, where that is known. Raises NotIdentifiable when no release can be found, since
    nothing can follow then.
    """
    found = found or locate(recording, options)
    aligned, refusals = found.decay, {"alignment": found.not_aligned} if found.not_aligned else {}
    orders = (options.max_order, options.stiffness_orders)

    def attempt(step: str, method: Callable[..., Value]) -> Value | None:
        try:
            return method(aligned, *orders)
        except NotIdentifiable as refusal:
            refusals[step] = str(refusal)
            return None

    wavelet = attempt("wavelet", identify_wavelet)
    restoring_force = attempt("restoring_force", identify_restoring_force)
    if wavelet is not None and restoring_force is not None:
        wavelet, restoring_force = _with_the_same_orders(aligned, wavelet, restoring_force, options.max_order)
    return Identification(
        found.recorded, found.release, found.alignment, aligned, wavelet, restoring_force, refusals
    )


def _with_the_same_orders(
    decay: FreeDecay, wavelet: WaveletResult, force: RestoringForceResult, max_order: int
) -> tuple[WaveletResult, RestoringForceResult]:
    """Identify again by the method that lacks an order which the other one needs; one that cannot says what to do.

    Orders of stiffness come first: without one of them a method may find damping that is not there.
    """
    for _ in range(_ROUNDS):
        least, needed = needed_orders((wavelet, force))
        stiffness = {*needed, *force.stiffness_by_order}
        bends = stiffness & _BACKBONE <= wavelet.stiffness_by_order.keys()
        if not (bends and stiffness <= force.stiffness_by_order.keys()):
            least = 0
        wanted = (max_order, tuple(sorted(stiffness)), least)
        try:
            if wavelet.order < least or not bends:
                wavelet = identify_wavelet(decay, *wanted)
            elif force.order < least or not stiffness <= force.stiffness_by_order.keys():
                force = identify_restoring_force(decay, *wanted)
            else:
                break
        except NotIdentifiable:
            common = sorted(wavelet.stiffness_by_order.keys() & force.stiffness_by_order.keys())
            remedy = (
                "the methods could not be brought to the same orders; to compare them at the same ones: --max-order "
                f"{min(wavelet.order, force.order)} --stiffness-orders {','.join(map(str, common))}"
            )
            return wavelet, replace(force, reason=f"{force.reason}; {remedy}")
    return wavelet, force


def compare(name: str, prepared: PreparedDecay, known: KnownModel) -> Compared:
    """Fit a model to the session `name` and find where it fails; a long record is judged in its pieces.

    Forces are in N where the mass is known.
    """
    start = known.start((prepared,))
    baseline = fit_baseline((prepared,), known.model, start)
    seen = compare_baseline(baseline)
    return Compared(name, baseline, seen, _in_pieces(baseline, start or {}), known.words, known.remark)


def _in_pieces(whole: Baseline, known: dict[str, float]) -> Baseline:
    """Return a fit to a whole record as one to its pieces, from known values or the former's; itself where it is short."""
    parts = segments_of(whole.decays)
    if len(parts) < 2:
        return whole
    physics = {name: known.get(name, found.value) for name, found in whole.fit.parameters.items()}
    start = initial_values(parts, whole.fit.model, physics)
    return fit_baseline(parts, whole.fit.model, start)
