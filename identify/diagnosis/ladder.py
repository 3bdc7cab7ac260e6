"""The ladder: effects are added or removed one by one, and the error falls to the floor, rung by rung."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from identify.diagnosis.suspect import Suspect
from identify.diagnosis.suspects import candidate_terms, try_terms
from identify.effects.effect import Effect
from identify.effects.sensor_fault import SensorFault
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, fit_baseline, refit_at_floor
from identify.fitting.corrected_faults import corrected_faults
from identify.fitting.fit import Fit, fit
from identify.fitting.model_error import ModelError, errors_of
from identify.fitting.segments import segments_of
from identify.formatting import three_figures
from identify.free_decay import FreeDecay
from identify.model.model import Model, Term, base_model
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.summary import Summarised, Summary

_STILL_NEEDED = 12.0
"""Chi-square by which an effect must lower the misfit to keep its place once others have come."""

Progress = Callable[["Rung", str], None]


@dataclass(frozen=True, eq=False)
class Rung:
    """One step of the ladder: what was added or removed, the model as fitted, and its errors."""

    added: str
    removed: str
    baseline: Baseline
    error: ModelError

    @property
    def fit(self) -> Fit:
        """The fitted model of this rung."""
        return self.baseline.fit

    @property
    def stated(self) -> Fit:
        """The same with the standard errors that are stated: of the misfit that is there, where it is above the floor."""
        return self.baseline.stated(self.fit)

    @property
    def effects(self) -> tuple[str, ...]:
        """The effects' names."""
        return self.fit.model.names

    @property
    def at_floor(self) -> bool:
        """Whether the model leaves no more than noise does."""
        return self.baseline.at_floor


@dataclass(frozen=True, eq=False, repr=False)
class Ladder(Summarised):
    """The error, rung by rung, why it ends (empty while it may go on), and the verdict on the last rung."""

    rungs: tuple[Rung, ...]
    stopped_because: str = ""
    verdict: str = ""

    @property
    def top(self) -> Rung:
        """The present model."""
        return self.rungs[-1]

    def brief(self) -> Summary:
        """Return the errors of each rung, and why the ladder ends."""
        rows = [
            (
                f"+ {rung.added}"
                if rung.added
                else f"- {rung.removed}"
                if rung.removed
                else "model to begin with",
                three_figures(rung.error.force_mse_percent),
                three_figures(rung.error.motion_percent),
                three_figures(rung.error.chi_square),
                "yes" if rung.at_floor else "no",
            )
            for rung in self.rungs
        ]
        reason = (
            f"{self.stopped_because[:1].upper()}{self.stopped_because[1:]}." if self.stopped_because else ""
        )
        return Summary(
            f"Ladder: {' + '.join(self.top.effects)}",
            (reason,),
            ("effect", "force MSE %", "motion %", "reduced chi-square", "at the floor"),
            rows,
        )


def first_rung(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
    model: Model | None = None,
    known: dict[str, float] | None = None,
) -> Rung:
    """Return the rung on which a ladder stands: a model (the base model unless given) as fitted."""
    return rung_of(fit_baseline(segments_of(decays), model or base_model(), known))


def add_found(rung: Rung, suspect: Suspect, found: Fit) -> Rung:
    """Return the next rung: the model with an effect that a diagnosis named, from the values that it found.

    `found` is the fit with all that was named. The effect is also tried afresh, and the better end counts.
    """
    effect, base = suspect.effect, rung.fit
    if isinstance(effect, SensorFault) and effect.corrected_in_every_fit:
        return _name_corrected_fault(rung, effect)
    model = base.model.plus(suspect.term)
    values = {u.name: found.point[u.name] for u in found.unknowns if u.id.effect == effect.name}
    ends = [fit(model, base.windows, base.point | values, base.frequency)]
    ends += [c.fit for c in try_terms(rung.baseline.decays, base, (suspect.term,))]
    best = min(ends, key=lambda end: end.chi_square)
    return replace(rung_of(refit_at_floor(rung.baseline.decays, best)), added=effect.name)


def add_effect(rung: Rung, effect: Effect) -> Rung:
    """Return the next rung: the model with one more effect in its best variant.

    Raises ValueError when the effect is in the model, NotIdentifiable when this record cannot show it.
    """
    baseline = rung.baseline
    if effect.name in baseline.fit.model:
        raise ValueError(f"{effect.name} is in the model already")
    if isinstance(effect, SensorFault) and effect.corrected_in_every_fit:
        return _name_corrected_fault(rung, effect)
    unit = baseline.fit.windows[0].unit
    if not effect.has_meaning_for(unit):
        raise NotIdentifiable(
            f"{effect.name} acts on displacements in {' or '.join(effect.units)}; this record is in {unit}."
        )
    terms = candidate_terms(baseline.fit.model, (effect,), baseline.fit.windows[0])
    tried = try_terms(baseline.decays, baseline.fit, terms)
    if not tried:
        raise NotIdentifiable(f"This record has no channel that could show {effect.name}.")
    return replace(rung_of(refit_at_floor(baseline.decays, tried[0].fit)), added=effect.name)


def remove_effect(rung: Rung, name: str) -> Rung:
    """Return the next rung: the model without an effect; KeyError when it has none of that name."""
    baseline = rung.baseline
    model = baseline.fit.model.minus(name)
    found = fit(model, baseline.fit.windows, baseline.fit.point, baseline.fit.frequency)
    return replace(rung_of(refit_at_floor(baseline.decays, found)), removed=name)


def share_explained(rung: Rung, name: str) -> float | None:
    """Return the share, 0 to 1, of what the model leaves without an effect that it takes away; None where it is needed.

    An effect is needed where chi-square rises by more without it than chance lets any effect lower it.
    """
    without = remove_effect(rung, name)
    if _needed(rung, without):
        return None
    gain = without.fit.chi_square - rung.fit.chi_square
    return max(gain / without.fit.chi_square, 0.0)


def _needed(rung: Rung, without: Rung) -> bool:
    return without.fit.chi_square >= rung.fit.chi_square + _STILL_NEEDED * max(rung.fit.reduced, 1.0)


def without_needless_effects(rung: Rung, kept: set[str]) -> list[Rung]:
    """Return rungs that drop the effects without which the misfit hardly rises, the least useful first."""
    dropped: list[Rung] = []
    while True:
        here = dropped[-1] if dropped else rung
        tried = [remove_effect(here, name) for name in here.effects if name not in kept]
        tried = [r for r in tried if not _needed(here, r)]
        if not tried:
            return dropped
        dropped.append(min(tried, key=lambda r: r.fit.chi_square))


def _name_corrected_fault(rung: Rung, effect: Effect) -> Rung:
    """Name in the model a fault that every fit has corrected already."""
    baseline = rung.baseline
    found = [
        f.term for f in corrected_faults(baseline.decays, baseline.fit) if f.term.effect.name == effect.name
    ]
    model = baseline.fit.model.plus(found[0] if found else Term(effect))
    return replace(rung_of(replace(baseline, fit=replace(baseline.fit, model=model))), added=effect.name)


def rung_of(baseline: Baseline) -> Rung:
    """Return a fitted model as a rung, with its errors."""
    return Rung("", "", baseline, errors_of(baseline))
