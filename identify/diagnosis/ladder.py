"""The ladder: effects are added or removed one by one until the error falls to the noise floor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from identify.effects.effect import Effect
from identify.effects.families import FAMILY_OF
from identify.effects.sensor_fault import SensorFault
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, fit_baseline, refit_at_floor
from identify.fitting.corrected_faults import corrected_faults, unnamed_faults
from identify.fitting.fit import Fit, fit
from identify.fitting.model_error import ModelError, errors_of
from identify.fitting.segments import segments_of
from identify.formatting import sentence_case, three_figures
from identify.free_decay import FreeDecay
from identify.judging.suspect import Suspect
from identify.judging.suspects import candidate_terms, try_terms
from identify.model.model import Model, Term, base_model
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.residual import times
from identify.summary import Summarised, Summary

_STILL_NEEDED = 12.0
"""Chi-square by which an effect must lower the misfit to keep its place once others have come."""

Progress = Callable[["Step", str], None]


@dataclass(frozen=True, eq=False)
class Step:
    """One step of the ladder: what was added or removed, the model as fitted, and its errors."""

    added: str
    removed: str
    baseline: Baseline
    error: ModelError

    @property
    def fit(self) -> Fit:
        """The fitted model of this step."""
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
    """The error, step by step, why it ends (empty while it may go on), and the verdict on the last step."""

    steps: tuple[Step, ...]
    stopped_because: str = ""
    verdict: str = ""

    @property
    def top(self) -> Step:
        """The present model."""
        return self.steps[-1]

    def brief(self) -> Summary:
        """Summarize the errors of each step, and why the ladder ends."""
        rows = [
            (
                f"+ {step.added}"
                if step.added
                else f"- {step.removed}"
                if step.removed
                else "model to begin with",
                three_figures(step.error.force_mse_percent),
                three_figures(step.error.motion_percent),
                times(step.error.chi_square),
                "yes" if step.at_floor else "no",
            )
            for step in self.steps
        ]
        reason = f"{sentence_case(self.stopped_because)}." if self.stopped_because else ""
        return Summary(
            f"Ladder: {' + '.join(self.top.effects)}",
            (reason,),
            ("effect", "force MSE %", "motion %", "times noise", "at the floor"),
            rows,
        )


def first_step(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
    model: Model | None = None,
    known: dict[str, float] | None = None,
) -> Step:
    """Fit the first step of a ladder: the base model unless another is given."""
    return step_of(fit_baseline(segments_of(decays), model or base_model(), known))


def add_found(step: Step, suspect: Suspect, found: Fit) -> Step:
    """Add an effect that a diagnosis named, from the values that it found.

    `found` is the fit with all that was named. The effect is also tried afresh, and the better end counts.
    """
    effect, base = suspect.effect, step.fit
    if isinstance(effect, SensorFault) and effect.corrected_in_every_fit:
        return _name_corrected_fault(step, effect)
    model = base.model.plus(suspect.term)
    values = {u.name: found.point[u.name] for u in found.unknowns if u.id.effect == effect.name}
    ends = [fit(model, base.windows, base.point | values, base.frequency)]
    ends += [c.fit for c in try_terms(step.baseline.decays, base, (suspect.term,))]
    best = min(ends, key=lambda end: end.chi_square)
    return replace(step_of(refit_at_floor(step.baseline.decays, best)), added=effect.name)


def add_effect(step: Step, effect: Effect) -> Step:
    """Add one more effect in its best variant.

    Raises ValueError when the effect is in the model, NotIdentifiable when this record cannot show it.
    """
    baseline = step.baseline
    if effect.name in baseline.fit.model:
        raise ValueError(f"{effect.name} is in the model already")
    if isinstance(effect, SensorFault) and effect.corrected_in_every_fit:
        return _name_corrected_fault(step, effect)
    unit = baseline.fit.windows[0].unit
    if not effect.has_meaning_for(unit):
        raise NotIdentifiable(
            f"{effect.name} acts on displacements in {' or '.join(effect.units)}; this record is in {unit}."
        )
    terms = candidate_terms(baseline.fit.model, (effect,), baseline.fit.windows[0])
    if effect in FAMILY_OF:
        terms = (Term(effect, FAMILY_OF[effect].held(baseline.scales)),)
    tried = try_terms(baseline.decays, baseline.fit, terms)
    if not tried:
        raise NotIdentifiable(f"This record has no channel that could show {effect.name}.")
    return replace(step_of(refit_at_floor(baseline.decays, tried[0].fit)), added=effect.name)


def remove_effect(step: Step, name: str) -> Step:
    """Remove an effect from the model; KeyError when the model has none of that name."""
    baseline = step.baseline
    model = baseline.fit.model.minus(name)
    found = fit(model, baseline.fit.windows, baseline.fit.point, baseline.fit.frequency)
    return replace(step_of(refit_at_floor(baseline.decays, found)), removed=name)


def needless_share(step: Step, without: Step) -> float | None:
    """Return the share, 0 to 1, of the misfit without a needless effect that it explains; None where it is needed.

    An effect is needed where chi-square rises by more without it than chance lets any effect lower it.
    """
    if _needed(step, without):
        return None
    left = _chi_square(without)
    return max((left - _chi_square(step)) / left, 0.0)


def _needed(step: Step, without: Step) -> bool:
    return _chi_square(without) >= _chi_square(step) + _STILL_NEEDED * max(step.fit.reduced, 1.0)


def _chi_square(step: Step) -> float:
    """What a step leaves, with the faults that its fit corrects and its model does not name."""
    return step.fit.chi_square + sum(f.drop for f in unnamed_faults(step.baseline.decays, step.fit))


def without_needless_effects(step: Step, kept: set[str]) -> list[Step]:
    """Remove the effects without which the misfit hardly rises, the least useful first, a step each."""
    dropped: list[Step] = []
    while True:
        here = dropped[-1] if dropped else step
        tried = [remove_effect(here, name) for name in here.effects if name not in kept]
        tried = [r for r in tried if not _needed(here, r)]
        if not tried:
            return dropped
        dropped.append(min(tried, key=_chi_square))


def _name_corrected_fault(step: Step, effect: Effect) -> Step:
    """Name in the model a fault that every fit has corrected already."""
    baseline = step.baseline
    found = [
        f.term for f in corrected_faults(baseline.decays, baseline.fit) if f.term.effect.name == effect.name
    ]
    model = baseline.fit.model.plus(found[0] if found else Term(effect))
    return replace(step_of(replace(baseline, fit=replace(baseline.fit, model=model))), added=effect.name)


def step_of(baseline: Baseline) -> Step:
    """Make a step of a fitted model, with its errors."""
    return Step("", "", baseline, errors_of(baseline))
