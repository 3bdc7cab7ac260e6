"""Whether named effects explain more than a random walk of spring and damper, or a smooth law outside the library.

Where the floor is reached, some law of the library follows nearly any slow walk of the spring, and nearly any smooth law
that the library does not hold, to within the noise, with thousands of nats. A law counts by what it explains beyond both,
and it must leave nothing to explain. A law that is there needs no walk beside it; a walk that a law has followed still
shows in the residual of the law.

A law outside the library is any smooth function of displacement, of velocity or of time, as spring, damper or friction: a
series of Legendre polynomials whose coefficients are normal, those of higher orders smaller (a Gaussian process; Rasmussen
and Williams, 2006). The misfit is taken for linear in it. Every hypothesis has a random walk: what that explains is no law.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.polynomial import legendre

from identify.arrays import Array
from identify.effects.effect import Effect
from identify.evidence import Decided, Evidence, decide
from identify.fitting.baseline import Baseline
from identify.fitting.problem import Problem
from identify.fitting.random_walk import RandomWalk, changes_by, explained_by, walk_beside
from identify.judging.ranking import weigh_candidate
from identify.judging.suspects import Candidate, InPlace
from identify.judging.verdict import Judgement, verdict_of
from identify.priors import CLEAR, NAMELESS_IS, RIVALS_WITHIN, SIZES, SMALL, WALK_IS_KNOWN

_ORDERS = 8
"""Orders of a series: of the last one a law bends seven times from end to end."""

_NEAR, _LEADERS = 6, 3
"""Effects that are weighed with a walk of their own, and those of them whose motion is simulated with it."""

_LAWS: tuple[Callable[[Array, Array, Array], tuple[Array, Array]], ...] = (
    lambda u, v, t: (u, np.ones_like(u)),
    lambda u, v, t: (v, np.ones_like(v)),
    lambda u, v, t: (u, np.sign(v)),
    lambda u, v, t: (2.0 * np.abs(v) - 1.0, np.sign(v)),
    lambda u, v, t: (u, v),
    lambda u, v, t: (t, u),
    lambda u, v, t: (t, v),
    lambda u, v, t: (t, np.sign(v)),
)
"""The coordinate of a law and the factor of its force, from displacement, velocity and time within -1 and 1."""


def smooth_law_evidence(walk: RandomWalk) -> float:
    """Weigh a smooth law beside a fit, with its walk of spring and damper or in place of it, against the walk (nats).

    All coordinates are equally probable; a law's size is not known, and a large one is rarer. Half of the weight is on no
    walk.
    """
    place, misfit, follows = walk.place, walk.misfit, walk.follows
    of_walk, with_walk = follows.T @ follows, follows.T @ misfit
    known, _ = explained_by(of_walk, with_walk)
    # Where the motion was simulated with a walk, the misfit without one is only extrapolated.
    no_walk = 0.5 * (walk.without - float(misfit @ misfit)) - np.log(2.0) - walk.evidence
    rarer = -NAMELESS_IS * np.arange(len(SIZES) - 1)
    rarer -= np.logaddexp.reduce(rarer)
    each = []
    for law in _laws(place.problem, place.theta):
        free = place.jacobian.free(law)
        both, own, along = follows.T @ free, free.T @ free, free.T @ misfit
        products = np.block([[of_walk, both], [both.T, own]])
        for size, prior in zip(SIZES[1:], rarer, strict=True):
            scale = size / np.arange(1, _ORDERS + 1)
            wide = np.concatenate([np.ones(len(with_walk)), scale])
            beside, _ = explained_by(
                products * np.outer(wide, wide), np.concatenate([with_walk, along * scale])
            )
            alone, _ = explained_by(own * np.outer(scale, scale), along * scale)
            each.append(prior + max(beside - known, alone + no_walk))
    return float(np.logaddexp.reduce(each) - np.log(len(each) / len(rarer)))


def _laws(problem: Problem, theta: Array) -> Iterator[Array]:
    """Yield the change of the misfit by each law's polynomials, each as large as the spring at the largest amplitude.

    (readings, orders) each; one law holds for all releases.
    """
    motions = [problem.respond(theta, i) for i in range(len(problem.windows))]
    far = max(float(np.max(np.abs(motion.displacement))) for motion in motions)
    fast = max(float(np.max(np.abs(motion.velocity))) for motion in motions)
    last = max(float(window.clock[-1]) for window in problem.windows)
    places = [
        (motion.displacement / far, motion.velocity / fast, 2.0 * window.clock / last - 1.0)
        for window, motion in zip(problem.windows, motions, strict=True)
    ]
    off = np.zeros((len(problem.expected), _ORDERS))
    for law in _LAWS:
        windows = []
        for i, place in enumerate(places):
            along, factor = law(*place)
            series = legendre.legvander(np.clip(along, -1.0, 1.0), _ORDERS).T[1:]
            forces = far * problem.frequency**2 * factor * series
            windows.append(changes_by(problem, theta, i, list(forces)))
        yield np.concatenate([*windows, off])


def weigh(
    before: RandomWalk,
    nats: dict[str, float],
    effects: dict[str, Effect],
    last: RandomWalk,
    unit: float,
    alpha: float,
) -> Evidence:
    """Decide which effects are named, from their evidence `nats` against the fit before; each hypothesis has a random walk.

    `before` is the walk beside that fit, `last` that beside the fit with the leader; the others explain as much, and leave
    as much. `unit` is the unit of chi-square in which `nats` were counted, `alpha` the probability of none that is allowed.
    """
    shift = (last.evidence - before.evidence) / unit
    return decide(
        {name: one + shift for name, one in nats.items()},
        effects,
        unnamed=smooth_law_evidence(before) / unit,
        drift_weighed=True,
        alpha=alpha,
    )


def weighed(baseline: Baseline, judged: Judgement) -> Judgement:
    """Weigh a name against a walk and a law outside the library, each effect beside the others; `decided` has the outcome.

    It gets the walk that remains beside it, and `decided` the law. Either withholds a name that does not reach the floor. A
    law also withholds one at a guessed floor, and one of less than ten times its own evidence.
    """
    final = judged.final
    last, reached = walk_beside(final), baseline.adequate(final)
    if judged.places:
        unit = judged.places[0].tried[0].unit
        decided = [_weighed_in_place(baseline, place, last) for place in judged.places]
    else:
        near = [one for one in judged.ranked if one.claimed and one.plausible]
        unit = near[0].unit
        effects = {one.name: one.term.effect for one in near}
        nats = {one.name: one.evidence for one in near}
        drifts = baseline.floor_is_sure and last.evidence > RIVALS_WITHIN * unit
        before = baseline.walk.simulated if drifts else baseline.walk
        decided = [weigh(before, nats, effects, last, unit, baseline.alpha)]
    walk = last if last.evidence > RIVALS_WITHIN * unit else None
    left = smooth_law_evidence(last) / unit
    withheld: Decided = "named"
    if walk is not None and not reached:
        withheld = "leaves drift"
    elif not (_is_small(left, decided) if reached and baseline.floor_is_sure else left <= RIVALS_WITHIN):
        withheld = "no name"
    decided = [
        replace(one, beside=left, verdict=withheld if one.verdict == "named" else one.verdict)
        for one in decided
    ]
    return replace(judged, decided=tuple(decided), walk=walk)


def _is_small(left: float, decided: Sequence[Evidence]) -> bool:
    """Check that the evidence for a law outside the library is nothing, or a small part of that for what is named."""
    return all(left <= max(RIVALS_WITHIN, SMALL * max(one.nats.values(), default=0.0)) for one in decided)


def _weighed_in_place(baseline: Baseline, place: InPlace, last: RandomWalk) -> Evidence:
    """Weigh one of several effects against what may stand in its place, beside the others.

    It has no name where something else is clearly more probable there and makes no sense, and, where the floor is a guess,
    where its strength is not determined.
    """
    before, own = walk_beside(place.without), place.tried[0]
    # Far from the readings a fit knows its chi-square less well than the walk, which is linearised there.
    known = place.without.chi_square - own.fit.chi_square
    more = 0.5 * (before.without - last.without - known) / own.unit
    near = [one for one in place.tried if one.plausible]
    nats = {one.name: one.evidence + more for one in near}
    effects = {one.name: one.term.effect for one in near}
    found = weigh(before, nats, effects, last, own.unit, baseline.alpha)
    known = baseline.floor_is_sure or not own.term.is_force or _is_determined(own)
    named = found.verdict == "named"
    return replace(found, verdict="no name") if named and not (known and own.name in found.names) else found


def _is_determined(force: Candidate) -> bool:
    """Check that the record determines the strength of a force."""
    strength = force.fit.values[str(force.term.strength)]
    return abs(strength.value) > CLEAR * strength.std


def named_with_walk(baseline: Baseline, ranked: tuple[Candidate, ...]) -> Judgement | None:
    """Name the effect that reaches the floor together with a random walk, each one weighed with a walk of its own.

    None where no effect does, where a walk alone reaches it, or where a law remains that is not small. Of a rig that drifts
    neither a law of time is named, for a walk is now and then like one, nor a force that is a line, which follows any
    motion for a while.
    """
    alone = baseline.walk.simulated
    if baseline.reached_with(alone):
        return None
    near = [one for one in ranked if one.plausible][:_NEAR]
    gain = {one: weigh_candidate(baseline, baseline.fit, one, 1.0).evidence for one in near}
    linear = {one: walk_beside(one.fit) for one in near}
    leaders = sorted(near, key=lambda one: -(gain[one] + linear[one].evidence))[:_LEADERS]
    walks = {one: linear[one].simulated for one in leaders}
    together = {one: gain[one] + walk.evidence for one, walk in walks.items()}
    best = max(together, key=lambda one: together[one], default=None)
    if (
        best is None
        or not baseline.reached_with(walks[best])
        or (best.term.is_force and best.term.effect.line)
    ):
        return None
    unit = max(1.0, WALK_IS_KNOWN * walks[best].evidence)
    found = decide(
        {one.name: (nats - alone.evidence) / unit for one, nats in together.items()},
        {one.name: one.term.effect for one in ranked},
        unnamed=smooth_law_evidence(alone) / unit,
    )
    left = smooth_law_evidence(walks[best]) / unit
    if found.verdict != "named" or not _is_small(left, [found]):
        return None
    found = replace(found, beside=left)
    leads, *rest = (
        replace(one, claimed=one.name in found.names)
        for one in (best, *(one for one in ranked if one is not best))
    )
    return Judgement(verdict_of(best), (leads, *rest), best.fit, walk=walks[best], decided=(found,))


def with_walk(baseline: Baseline, judged: Judgement) -> Judgement:
    """Give a judgement without a name, at a sure floor, the random walk that explains all of the misfit, if one does.

    None does where every law that was weighed is better than it.
    """
    better = bool(judged.decided) and all(one.verdict != "nothing" for one in judged.decided)
    if judged.verdict != "unknown_effect" or not baseline.floor_is_sure or better:
        return judged
    alone = baseline.walk.simulated
    enough = alone.evidence > RIVALS_WITHIN and baseline.reached_with(alone)
    return replace(judged, walk=alone) if enough else judged


def walk_sentence(walk: RandomWalk | None, *, named: bool, releases: int) -> str:
    """Say what a random walk explains, beside a name or instead of one; "" where there is no walk."""
    if walk is None or not (walk.stiffness or walk.damping):
        return ""
    drifts = []
    if walk.stiffness:
        drifts.append(f"in stiffness of about {_one_figure(100.0 * walk.stiffness)} %")
    if walk.damping:
        drifts.append(f"in damping ratio of about {_one_figure(0.5 * walk.damping)}")
    drift = f"a random walk {' and '.join(drifts)} in one second"
    if named:
        return f"Besides what is named, {drift} remains; with it no other effect is likelier."
    apart = "A random walk is never the same twice, so several releases distinguish a law from it."
    return f"It may be no law at all: {drift} explains the residual as well.{f' {apart}' if releases == 1 else ''}"


def law_sentence(decided: Sequence[Evidence]) -> str:
    """Say that a law outside the library remains beside what is named; "" where none does."""
    left = any(one.beside > RIVALS_WITHIN for one in decided)
    return "Besides what is named, something small without a name remains." if left else ""


def _one_figure(value: float) -> str:
    """Round a size that is known to a factor of two to one figure."""
    return f"{value:.0f}" if value >= 1.0 else f"{value:.1g}"
