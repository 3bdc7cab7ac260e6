"""The hypotheses that a diagnosis leaves: the usual model, its leading suspects, a law without a name; and their odds."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array
from identify.diagnosis.nonparametric_force import NonparametricForce
from identify.diagnosis.suspect import Suspect
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit
from identify.formatting import among, plain_name
from identify.priors import RIVALS_WITHIN

_SUSPECTS = 4
_FREE_FORM = 24
"""Numbers that a law without a name takes: the knots of its spline over the displacement."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What may be true: the effects beyond the model that was asked about, fitted; `log_odds` are relative, nats.

    `shape` is the law without a name that acts beside the fit, None elsewhere.
    """

    names: tuple[str, ...]
    fit: Fit
    log_odds: float
    shape: NonparametricForce | None = None

    @property
    def title(self) -> str:
        """The name in a sentence."""
        if self.shape is not None:
            return "a law without a name"
        return among([plain_name(name) for name in self.names]) if self.names else "the usual model"

    def contains(self, other: "Hypothesis") -> bool:
        """Whether another is this one with something left out, so that it can follow all that the other does."""
        return set(other.fit.model.names) <= set(self.fit.model.names)


def hypotheses_of(
    baseline: Baseline,
    suspects: Sequence[Suspect],
    named: Sequence[str],
    final: Fit,
    shape: NonparametricForce | None = None,
) -> tuple[Hypothesis, ...]:
    """Return the hypotheses, the likeliest first: by chi-square with BIC's penalty (Schwarz 1978).

    `named` is what the verdict names, fitted in `final`. Where the floor is a guess, chi-square counts in units of what the
    best of them leaves. Where nothing is claimed they are forces that another amplitude may show, the closest and those
    by which a detection limit is told.
    """
    rivals = suspects[0].rivals if len(named) == 1 else ()
    found: dict[tuple[str, ...], Hypothesis] = {(): Hypothesis((), baseline.fit, 0.0)}
    if named:
        own = _at_the_same_floor(baseline, suspects[0], named, final)
        if own is baseline.fit:  # a fault that every fit corrects: the usual model without it was not fitted
            del found[()]
        found[tuple(named)] = Hypothesis(tuple(named), own, 0.0)
    quiet = not named and not any(suspect.claimed for suspect in suspects)
    closest = sorted(suspects, key=lambda suspect: (quiet and not _hides(suspect), suspect.fit.chi_square))
    for suspect in closest:
        if suspect.fit is baseline.fit or not suspect.plausible or suspect.effect.name in named:
            continue
        if len(found) > _SUSPECTS + bool(named) and not (quiet and suspect.effect.shows_detection_limit):
            continue
        name = (suspect.effect.name,)
        found.setdefault(name, Hypothesis(name, suspect.fit, 0.0))
    for suspect in suspects:
        if suspect.effect.name in rivals and suspect.fit is not baseline.fit:
            name = (suspect.effect.name,)
            found.setdefault(name, Hypothesis(name, suspect.fit, 0.0))
    best = min(found.values(), key=lambda one: one.fit.chi_square).fit
    unit = 1.0 if baseline.floor_is_sure else max(best.reduced, 1.0)
    if shape is not None and shape.shapes:
        found["",] = Hypothesis((), baseline.fit, 0.0, shape)
    weighed = [replace(one, log_odds=log_odds(one, unit)) for one in found.values()]
    if named:
        weighed = [_as_judged(one, weighed, tuple(named), rivals) for one in weighed]
    highest = max(one.log_odds for one in weighed)
    weighed = [replace(one, log_odds=one.log_odds - highest) for one in weighed]
    return tuple(sorted(weighed, key=lambda one: -one.log_odds))


def _at_the_same_floor(baseline: Baseline, first: Suspect, named: Sequence[str], final: Fit) -> Fit:
    """Return what is named as it is fitted against the noise of all other suspects: `final` has that of its own residual."""
    if len(named) == 1:
        return first.fit
    return fit(final.model, baseline.fit.windows, final.point, baseline.fit.frequency, near=True)


def _hides(suspect: Suspect) -> bool:
    """Whether an effect may show at another amplitude: what goes by the clock shows at each."""
    effect = suspect.effect
    return suspect.kind == "physics" and not effect.line and not effect.of_time


def log_odds(one: Hypothesis, unit: float) -> float:
    """Return the odds of a hypothesis by its fit, nats; chi-square counts in units of `unit`."""
    shared = sum(unknown.id.role == "parameter" for unknown in one.fit.unknowns)
    price = 0.5 * float(np.log(max(one.fit.degrees, 2)))
    if one.shape is not None:
        return -0.5 * one.fit.degrees - price * (shared + _FREE_FORM)
    return -0.5 * one.fit.chi_square / unit - price * shared


def _as_judged(
    one: Hypothesis, weighed: Sequence[Hypothesis], named: tuple[str, ...], rivals: Sequence[str]
) -> Hypothesis:
    """Return a hypothesis with odds that agree with the verdict, which knows more: the rest, and the curves of the decay.

    A rival of what is named is no farther behind it than what is not distinguishable, all else no nearer.
    """
    leads = next(other.log_odds for other in weighed if other.names == named)
    if one.names == named:
        return one
    if len(one.names) == 1 and one.names[0] in rivals:
        return replace(one, log_odds=float(np.clip(one.log_odds, leads - RIVALS_WITHIN, leads)))
    return replace(one, log_odds=min(one.log_odds, leads - RIVALS_WITHIN))


def odds(hypotheses: Sequence[Hypothesis]) -> Array:
    """Return the probability of each hypothesis beside the others, (hypotheses,)."""
    weights = np.exp([one.log_odds - hypotheses[0].log_odds for one in hypotheses])
    return np.asarray(weights / weights.sum())
