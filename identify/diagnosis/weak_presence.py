"""Weak presence: points near a fit at which one more effect is there, but hardly."""

import numpy as np

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.fitting.initial_values import inner_values, rest_states
from identify.fitting.problem import Problem
from identify.model.measured_path import force_along
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay

_EARLY = 200
"""Samples of the motion along which a rough size of a force is taken, or one cycle where that has more."""


def states_of_term(base: Fit, term: Term, inner: dict[str, float]) -> dict[str, float]:
    """Return the internal states of one more effect, by unknown's name, at the starts of the releases of a fit."""
    found: dict[str, float] = {}
    count = len(base.windows)
    for i in range(count):
        start = base.of_release(i)
        states = rest_states(term, start["displacement"], start["velocity"], inner)
        found |= {str(id.of_release(i, count)): value for id, value in states.items()}
    return found


def with_fault(base: Fit, term: Term, start: dict[str, float]) -> dict[str, float]:
    """Return a fit's values with a sensor's fault in every release.

    Of several, a line has a size and a phase of its own in each.
    """
    point, count = base.point, len(base.windows)
    for i in range(count):
        own = _line_of_release(base, term, start, i) if term.effect.line and count > 1 else start
        point |= {str(term.parameter(name).of_release(i, count)): value for name, value in own.items()}
    return point


def _line_of_release(base: Fit, term: Term, start: dict[str, float], i: int) -> dict[str, float]:
    """Return the values of a line of the frequency of `start` as the residual of release i shows it."""
    window = base.windows[i]
    units = {p.unit: p.name for p in term.effect.parameters}
    used = window.used[term.channel]
    angle = 2.0 * np.pi * start[units["Hz"]] * window.clock[used]
    waves = np.column_stack([np.sin(angle), np.cos(angle)])
    sine, cosine = np.linalg.lstsq(waves, base.residual(term.channel, i)[used], rcond=None)[0]
    own = {
        term.effect.strength.name: float(np.hypot(sine, cosine)),
        units["rad"]: float(np.arctan2(cosine, sine) % (2.0 * np.pi)),
    }
    return start | own


def probes(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    problem: Problem,
    term: Term,
    start: dict[str, float],
    share: float,
    *,
    early: bool = False,
) -> list[Array]:
    """Return points near a fit at which a force is weakly present, one for each of its linear freedoms.

    `problem` is that of the model with the term, `start` has its inner parameters by their own names; its rms force is a
    `share` of the acceleration, along the whole motion or, where a rough size will do, `early` in it.
    """
    largest = max(decays, key=lambda prepared: prepared.amplitude)
    begun = term.by_name(start)
    inner = {name: estimate.value for name, estimate in base.parameters.items()} | begun
    motion = largest.motion
    cycle = int(2.0 * np.pi / largest.frequency * largest.window.rate) + 1  # a stop may be on the other side
    until = min(max(_EARLY, cycle), len(largest.time)) if early else len(largest.time)
    along = (largest.time[:until], motion.displacement[:until], motion.velocity[:until], largest.frequency)
    force = force_along(term, inner_values(term, inner), *along)
    with np.errstate(over="ignore", invalid="ignore"):  # what is too stiff for a measured motion runs away
        rms = float(np.sqrt(np.mean(force**2)))
    if not 0.0 < rms < np.inf:
        return []
    strength = share * float(np.sqrt(np.mean(motion.acceleration[:until] ** 2))) / rms
    states = states_of_term(base, term, inner)
    point = base.point | begun | {str(term.strength): strength} | states
    points = [point]
    sizes = term.force.state_sizes(largest.amplitude, largest.frequency)
    for i in range(len(base.windows)):
        for j in range(term.force.states):
            name = str(term.state(j).of_release(i, len(base.windows)))
            if name in states and name in problem.index:
                points.append(point | {name: states[name] + 0.5 * sizes[j]})
    return [problem.theta(p) for p in points]
