"""The whole analysis from a recording to the ladder, one function a step; each takes the results of the last one.

- `identify`: recording -> release, noise, alignment, wavelet, restoring force
- `adequacy`: prepared decay, both methods -> the judgement on the model that they identified (station.story.adequacy)
- `prepare_session`: session -> a release that can be fitted (station.story.preparation)
- `compare`: prepared decay, model -> the fitted model, and where it fails
- `identify.diagnosis.diagnose.diagnose`: prepared decays, model -> what the model lacks
- `identify.diagnosis.diagnose.refine`: prepared decay, model -> the ladder: the error, step by step, as effects are added
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from daq.recording import Recording
from identify.comparison.compare import compare_fitted as compare_baseline
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, fit_baseline
from identify.fitting.initial_values import initial_values
from identify.fitting.segments import segments_of
from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import AlignedDecay
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.restoring_force.restoring_force import RestoringForceResult, identify_restoring_force
from identify.wavelet.wavelet import STIFFNESS_ORDERS, WaveletResult, identify_wavelet
from station.story.adequacy import needed_orders
from station.story.compared import Compared
from station.story.identification import Identification
from station.story.known_model import KnownModel
from station.story.preparation import Options, locate

Value = TypeVar("Value")
Progress = Callable[[str], None]

_BACKBONE = set(STIFFNESS_ORDERS[-1])
"""Orders of stiffness that the backbone shows; even ones leave it straight."""

_ROUNDS = 4
"""An order that one method takes over may make the other need one more."""


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
    """Identify again by the method that lacks an order which the other one needs; one that cannot says what to do."""
    for _ in range(_ROUNDS):
        least, needed = needed_orders((wavelet, force))
        stiffness = {*needed, *force.stiffness_by_order}
        wanted = (max_order, tuple(sorted(stiffness)), least)
        try:
            if wavelet.order < least or not stiffness & _BACKBONE <= wavelet.stiffness_by_order.keys():
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
    seen = compare_baseline(baseline, mass=prepared.mass)
    return Compared(name, baseline, seen, _in_pieces(baseline, start or {}), known.words, known.remark)


def _in_pieces(whole: Baseline, known: dict[str, float]) -> Baseline:
    """Return a fit to a whole record as one to its pieces, from known values or the former's; itself where it is short."""
    parts = segments_of(whole.decays)
    if len(parts) < 2:
        return whole
    physics = {name: known.get(name, found.value) for name, found in whole.fit.parameters.items()}
    start = initial_values(parts, whole.fit.model, physics)
    return fit_baseline(parts, whole.fit.model, start)
