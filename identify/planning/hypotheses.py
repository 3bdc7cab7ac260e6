"""The hypotheses that a diagnosis leaves: the usual model, its leading suspects, a law outside the library; their odds."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace

import numpy as np

from identify.arrays import Array
from identify.effects.effect import Effect, Scales
from identify.effects.families import FAMILIES
from identify.evidence import evidence, price
from identify.fitting.baseline import Baseline, residual_lines
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import close_starts, scales_of
from identify.fitting.random_walk import RandomWalk
from identify.formatting import among, plain_name
from identify.judging.nonparametric_force import NonparametricForce
from identify.judging.ranking import at_rest, chi_square_unit
from identify.judging.suspect import Suspect
from identify.judging.suspects import InPlace, candidate_terms, laws_of_families, try_terms
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import RIVALS_WITHIN

_SUSPECTS = 4
_FREE_FORM = 24
"""Numbers that a law outside the library takes: the knots of its spline over the displacement."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A hypothesis: the effects beyond the diagnosed model, fitted; `log_odds` are relative, nats.

    `beside` is the law outside the library, or the random walk of spring and damper, that acts beside the fit; else None.
    `within` are inner parameters that would leave the range that the effect is named for, held at its end; with
    `free`, the fit in which they do. `reach` are the ends of such ranges by unknown's name.
    """

    names: tuple[str, ...]
    fit: Fit
    log_odds: float
    beside: NonparametricForce | RandomWalk | None = None
    within: Mapping[str, float] = field(default_factory=dict)
    reach: Mapping[str, float] = field(default_factory=dict)
    free: Fit | None = None

    @property
    def title(self) -> str:
        """The name in a sentence."""
        if isinstance(self.beside, NonparametricForce):
            return "a law outside the library"
        if isinstance(self.beside, RandomWalk):
            return "a random walk of spring and damper"
        free = {family.effect.name: f" with any {family.free}" for family in FAMILIES}
        called = [f"{plain_name(name)}{free.get(name, '')}" for name in self.names]
        return among(called) if called else "the usual model"

    @property
    def has_law(self) -> bool:
        """Whether it is a model that can be refitted: no random walk, no law outside the library."""
        return self.beside is None

    def contains(self, other: "Hypothesis") -> bool:
        """Check whether another is this one with something left out or its exponent held, so that this can follow it."""
        held = (family.members for family in FAMILIES if family.effect.name in self.names)
        return set(other.fit.model.names) <= set(self.fit.model.names).union(*held)


def hypotheses_of(
    baseline: Baseline,
    suspects: Sequence[Suspect],
    named: Sequence[str],
    final: Fit,
    shape: NonparametricForce | None = None,
    walk: RandomWalk | None = None,
    places: Sequence[InPlace] = (),
    undecided: Set[str] = frozenset(),
) -> tuple[Hypothesis, ...]:
    """List the hypotheses, the likeliest first, with the evidence that ranks them (`marginal_likelihood`).

    `named` is what the verdict names, fitted in `final`; `places` say what was tried in the place of each of several;
    `undecided` are the effects among which curves could not decide. Where nothing is claimed they are forces that another
    amplitude may show: the closest ones, and those for which a detection limit is stated.
    """
    rivals = suspects[0].rivals if len(named) == 1 else ()
    found: dict[tuple[str, ...], Hypothesis] = {(): Hypothesis((), baseline.fit, 0.0)}
    if named:
        # `final` is fitted against the noise of its own residual, all other suspects against that of the baseline.
        own = suspects[0].fit
        if len(named) > 1:
            own = fit(final.model, baseline.fit.windows, final.point, baseline.fit.frequency, near=True)
        elif suspects[0].corrected is not None:  # the usual model without it was not fitted
            del found[()]
        found[tuple(named)] = Hypothesis(tuple(named), own, 0.0)
    quiet = not named and not undecided and not any(suspect.claimed for suspect in suspects)
    scales = baseline.scales
    recorded = replace(scales, duration=max(map(_recorded, baseline.decays)))
    for suspect in sorted(suspects, key=lambda one: (quiet and not _hides(one), one.fit.chi_square)):
        name = suspect.effect.name
        if suspect.corrected is not None or name in named:
            continue
        few = len(found) <= _SUSPECTS + bool(named) or (quiet and suspect.effect.shows_detection_limit)
        if name in rivals or name in undecided or (few and (suspect.plausible or _is_bounded(suspect))):
            found.setdefault((name,), _within_reach(baseline.decays, suspect, recorded))
    # Most laws of a family follow a guessed floor: there only those are hypotheses that are suspects.
    one_name = len(named) == 1 and baseline.floor_is_sure
    near = [suspect for suspect in suspects if (suspect.effect.name,) in found] if one_name else ()
    laws = laws_of_families(baseline, [suspect.effect.name for suspect in near])
    between = [Hypothesis((law.name,), law.fit, 0.0) for law in laws if law.plausible]
    for one in (*_exchanged(named, places), *between):
        found.setdefault(one.names, one)
    unit = chi_square_unit(baseline, [one.fit for one in found.values() if one.names])
    none = float(np.log(max(len(suspects), 1)))  # to begin with as probable as all suspects together
    weighed = []
    for one in found.values():
        known = _log_odds(one, baseline.fit, scales, unit) + _at_rest(baseline, one.fit)
        weighed.append(replace(one, log_odds=known if one.names else none))
    if shape is not None and shape.shapes:
        weighed.append(Hypothesis((), baseline.fit, _of_shape(baseline.fit, unit), shape))
    if walk is not None:
        weighed.append(Hypothesis((), baseline.fit, walk.evidence, walk))
    judged = {(), *((suspect.effect.name,) for suspect in suspects)}
    weighed = _agreeing(weighed, judged, named, rivals, undecided, quiet=quiet)
    highest = max(one.log_odds for one in weighed)
    weighed = [replace(one, log_odds=one.log_odds - highest) for one in weighed]
    return tuple(sorted(weighed, key=lambda one: -one.log_odds))


def _agreeing(
    weighed: list[Hypothesis],
    judged: set[tuple[str, ...]],
    named: Sequence[str],
    rivals: Sequence[str],
    undecided: Set[str],
    *,
    quiet: bool,
) -> list[Hypothesis]:
    """Set the odds of the hypotheses to agree with the verdict, as far as it judged; `quiet` where nothing is claimed.

    Effects among which nothing is decided are as probable as one another, and no other hypothesis is more so.
    """
    nameless = [one.log_odds for one in weighed if not one.has_law]
    rest = [one for one in weighed if undecided.isdisjoint(one.names)]
    if len(rest) < len(weighed):
        behind = max(one.log_odds for one in rest) + _apart(len(rest))
        weighed = [replace(one, log_odds=one.log_odds - behind if one in rest else 0.0) for one in weighed]
    elif named:
        weighed = [
            _as_judged(one, weighed, tuple(named), rivals) if one.names in judged else one for one in weighed
        ]
    elif nameless or quiet:
        usual = next(one.log_odds for one in weighed if one.has_law and not one.names)
        most = max(nameless) - _apart(len(weighed) - len(nameless)) if nameless else usual
        weighed = [replace(one, log_odds=min(one.log_odds, most)) if one.has_law else one for one in weighed]
    return weighed


def _log_odds(one: Hypothesis, base: Fit, scales: Scales, unit: float) -> float:
    """Return the evidence (nats) of a hypothesis against the `base` without its effects, in a `unit` of chi-square."""
    gain = 0.5 * (base.chi_square - one.fit.chi_square) / unit
    return gain - price(base, one.free or one.fit, scales, unit)


def _of_shape(base: Fit, unit: float) -> float:
    """Return the evidence (nats) of a law that leaves nothing but noise, each of its knots at BIC's price."""
    gain = 0.5 * max(base.chi_square - unit * base.degrees, 0.0) / unit
    return gain - 0.5 * _FREE_FORM * float(np.log(max(base.degrees, 2)))


def _at_rest(baseline: Baseline, found: Fit) -> float:
    """Return the evidence (nats) of the rest before the releases for what a fit has beyond the baseline."""
    added = (term for term in found.model.terms if term.effect.name not in baseline.fit.model)
    return sum(at_rest(baseline.decays, found, term) for term in added)


def _exchanged(named: Sequence[str], places: Sequence[InPlace]) -> list[Hypothesis]:
    """List the named sets with one of several effects exchanged for one that it may be mistaken for."""
    return [
        Hypothesis(tuple(one.name if name == own.name else name for name in named), one.fit, 0.0)
        for own, *others in (place.tried for place in places)
        for one in others
        if one.plausible
    ]


def _within_reach(decays: Sequence[PreparedDecay], suspect: Suspect, scales: Scales) -> Hypothesis:
    """Make a suspect a hypothesis; the inner parameters of a law of time stay within the range of its name.

    Beyond it the same force has another name: a stiffness that settles in hours drifts.
    """
    name, term, found = (suspect.effect.name,), suspect.term, suspect.fit
    if not _is_bounded(suspect):
        return Hypothesis(name, found, 0.0)
    own = {key: estimate.value for key, estimate in found.of(term, 0).items()}
    starts = close_starts(term, scales)
    most = {key: max(start[key] for start in starts) for key in term.effect.inner}
    within = {key: end for key, end in most.items() if own[key] > end}
    reach = {str(term.parameter(key)): end for key, end in most.items()}
    if not within:
        return Hypothesis(name, found, 0.0, reach=reach)
    held = Term(suspect.effect, {**term.held, **within})
    model = Model(tuple(held if t.effect.name == name[0] else t for t in found.model.terms))
    largest = max(decays, key=lambda decay: decay.amplitude)
    path = (largest.time, largest.motion.displacement, largest.motion.velocity, largest.frequency)
    there, here = force_along(term, own, *path), force_along(term, own | within, *path)
    share = float(there @ here) / max(float(here @ here), 1e-300)
    start = found.point | {str(term.strength): share * own[term.effect.strength.name]}
    inside = fit(model, found.windows, start, found.frequency, near=True)
    return Hypothesis(name, inside, 0.0, within=within, free=found)


def _is_bounded(suspect: Suspect) -> bool:
    """Check whether a suspect is held within the range of its name, where it is plausible whatever was fitted."""
    return suspect.effect.of_time and bool(suspect.effect.inner)


def _recorded(decay: PreparedDecay) -> float:
    """Return the recorded time of a release (s), of which the moving part is fitted."""
    share = decay.use.share if decay.use is not None else 1.0
    return len(decay.window) / decay.window.rate / max(share, 0.05)


def _hides(suspect: Suspect) -> bool:
    """Check whether an effect may show at another amplitude only: a law of time shows at each."""
    effect = suspect.effect
    return suspect.kind == "physics" and not effect.line and not effect.of_time


def _as_judged(
    one: Hypothesis, weighed: Sequence[Hypothesis], named: tuple[str, ...], rivals: Sequence[str]
) -> Hypothesis:
    """Set the odds of a hypothesis to agree with the verdict, which also knows the curves of the decay.

    A rival of what is named is no farther behind it than what is not distinguishable, all else together no nearer.
    """
    leads = next(other.log_odds for other in weighed if other.names == named)
    if one.names == named:
        return one
    if one.names and one.names[0] in rivals:
        lowest = -np.inf if one.within else leads - RIVALS_WITHIN
        return replace(one, log_odds=float(np.clip(one.log_odds, lowest, leads)))
    return replace(one, log_odds=min(one.log_odds, leads - _apart(len(weighed) - 1 - len(rivals))))


def _apart(others: int) -> float:
    """Return the nats by which each of several excluded hypotheses is behind at least: together they have DOUBT."""
    return RIVALS_WITHIN + float(np.log(max(others, 1)))


def what_can_hide(
    decays: tuple[PreparedDecay, ...], lead: Hypothesis, library: Sequence[Effect]
) -> tuple[Hypothesis, ...]:
    """List what may act beside a hypothesis, as strong as the releases still allow, with its odds.

    These are the effects with stated detection limits: one that grows with the displacement, one with the speed. Before
    the data, none is as probable as all together.
    """
    effects = [effect for effect in library if effect.shows_detection_limit and effect.name not in lead.names]
    terms = candidate_terms(lead.fit.model, effects, decays[0].window)
    scales = scales_of(decays[0], residual_lines(lead.fit))
    tried = try_terms(decays, lead.fit, terms)
    return tuple(
        Hypothesis((one.name,), one.fit, evidence(lead.fit, one.fit, scales) - float(np.log(len(tried))))
        for one in tried
    )


def odds(hypotheses: Sequence[Hypothesis]) -> Array:
    """Return the probability of each hypothesis beside the others, (hypotheses,)."""
    weights = np.exp([one.log_odds - hypotheses[0].log_odds for one in hypotheses])
    return np.asarray(weights / weights.sum())
