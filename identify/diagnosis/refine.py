"""Refinement: effects are added one by one, and the error falls to the floor, rung by rung."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from identify.diagnosis.diagnose import Diagnosis, diagnose
from identify.diagnosis.suspects import candidate_terms, try_terms
from identify.effects.effect import Effect
from identify.effects.library import LIBRARY, find_effect
from identify.effects.sensor_fault import SensorFault
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, fit_baseline, refit_at_floor
from identify.fitting.corrected_faults import corrected_faults
from identify.fitting.fit import Fit, fit
from identify.fitting.model_error import ModelError, errors_of
from identify.fitting.segments import segments
from identify.model.model import Model, Term, base_model
from identify.preprocessing.prepared_decay import PreparedDecay

_MOST_RUNGS = 5
_STILL_EARNS = 12.0
"""Chi-square by which an effect must lower the misfit to keep its place once others have come."""


@dataclass(frozen=True, eq=False)
class Rung:
    """One step of the ladder: what was added or removed, the model as fitted, and its errors."""

    added: str
    removed: str
    start: Baseline
    error: ModelError

    @property
    def fit(self) -> Fit:
        """The fitted model of this rung."""
        return self.start.fit

    @property
    def effects(self) -> tuple[str, ...]:
        """The effects' names."""
        return self.fit.model.names


@dataclass(frozen=True, eq=False)
class Ladder:
    """The error, rung by rung, and why the climb stopped (empty while it may go on)."""

    rungs: tuple[Rung, ...]
    stopped_because: str = ""
    verdict: str = ""

    @property
    def top(self) -> Rung:
        """The present model."""
        return self.rungs[-1]


def first_rung(
    decays: tuple[PreparedDecay, ...], model: Model | None = None, known: dict[str, float] | None = None
) -> Rung:
    """Return the rung on which a ladder stands: a model (the base model unless given) as fitted."""
    pieces = tuple(segment for prepared in decays for segment in segments(prepared))
    return _rung(fit_baseline(pieces, model or base_model(), known))


def add_effect(rung: Rung, effect: Effect, *, library: tuple[Effect, ...] = LIBRARY) -> Rung:
    """Return the next rung: the model with one more effect in its best variant.

    Raises ValueError when the effect is in the model, NotIdentifiable when this record cannot show it.
    """
    start = rung.start
    if effect.name in start.fit.model:
        raise ValueError(f"{effect.name} is in the model already")
    if isinstance(effect, SensorFault) and effect.corrected_in_every_fit:
        return _own_up(rung, effect)
    unit = start.fit.windows[0].unit
    if not effect.has_meaning_for(unit):
        raise NotIdentifiable(
            f"{effect.name} acts on displacements in {' or '.join(effect.units)}; this record is in {unit}."
        )
    terms = candidate_terms(start.fit.model, (effect,), start.fit.windows[0])
    tried = try_terms(start.decays, start.fit, terms)
    if not tried:
        raise NotIdentifiable(f"This record has no channel that could show {effect.name}.")
    return replace(_rung(refit_at_floor(start.decays, tried[0].fit)), added=effect.name)


def remove_effect(rung: Rung, name: str) -> Rung:
    """Return the next rung: the model without an effect; KeyError when it has none of that name."""
    start = rung.start
    model = start.fit.model.minus(name)
    known = dict(zip(start.fit.names, start.fit.theta.tolist(), strict=True))
    found = fit(model, start.fit.windows, known, start.fit.frequency)
    return replace(_rung(refit_at_floor(start.decays, found)), removed=name)


def climb(
    decays: tuple[PreparedDecay, ...],
    model: Model | None = None,
    *,
    library: tuple[Effect, ...] = LIBRARY,
    known: dict[str, float] | None = None,
    progress: Callable[[Rung, str], None] = lambda rung, words: None,
) -> tuple[Ladder, Diagnosis]:
    """Add what is missing until nothing is, checking backwards whether each effect still earns its place.

    `progress` is called with each new rung and a sentence. Returns the ladder and the last diagnosis.
    """
    rungs = [first_rung(decays, model, known)]
    own = set(rungs[0].effects)
    progress(rungs[0], "the model to begin with")
    while True:
        top = rungs[-1]
        here = dict(zip(top.fit.names, top.fit.theta.tolist(), strict=True))
        found = diagnose(decays, top.fit.model, library=library, known=here)
        reason = _reason_to_stop(found, len(rungs))
        if reason:
            return Ladder(tuple(rungs), reason, found.verdict), found
        for name in found.named:
            rungs.append(add_effect(rungs[-1], find_effect(name, library), library=library))
            progress(rungs[-1], f"added {name}")
        for rung in _backwards(rungs[-1], own | {rungs[-1].added}):
            rungs.append(rung)
            progress(rung, f"removed {rung.removed}: it no longer earns its place")


def _reason_to_stop(found: Diagnosis, rungs: int) -> str:
    if found.verdict == "nothing_missing":
        return (
            "the noise floor is reached: no effect of the library lowers the error by more than chance would"
        )
    if found.verdict == "unknown_effect":
        return "something is missing that the library does not name; see the free form"
    if found.verdict == "not_enough_data":
        return "the record is too short to tell more effects apart"
    if rungs > _MOST_RUNGS:
        return f"{_MOST_RUNGS} effects were added; a model with more would explain anything"
    return ""


def _backwards(rung: Rung, kept: set[str]) -> list[Rung]:
    """Return rungs that drop the effects without which the misfit hardly rises, the least useful first."""
    dropped: list[Rung] = []
    while True:
        here = dropped[-1] if dropped else rung
        tried = [remove_effect(here, name) for name in here.effects if name not in kept]
        tried = [
            r
            for r in tried
            if r.fit.chi_square - here.fit.chi_square < _STILL_EARNS * max(here.fit.reduced, 1.0)
        ]
        if not tried:
            return dropped
        dropped.append(min(tried, key=lambda r: r.fit.chi_square))


def _own_up(rung: Rung, effect: Effect) -> Rung:
    """Name in the model a fault that every fit has corrected already."""
    start = rung.start
    found = [f.term for f in corrected_faults(start.decays, start.fit) if f.term.effect.name == effect.name]
    model = start.fit.model.plus(found[0] if found else Term(effect))
    return replace(_rung(replace(start, fit=replace(start.fit, model=model))), added=effect.name)


def _rung(start: Baseline) -> Rung:
    return Rung("", "", start, errors_of(start))
