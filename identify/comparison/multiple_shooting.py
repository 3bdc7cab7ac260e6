"""Multiple shooting: the model run afresh over every cycle, from the state that was measured.

A wrong model drifts away from the measurement, and the misfit of a free run then shows more of the cycles before
than of the present one. Started anew every cycle from the measured state, the model stays so close that what it lacks
is the small force that explains the rest: readings and noise as recorded, nothing is differentiated.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from identify.arrays import Array
from identify.effects.force_effect import LinearPart
from identify.fitting.fit import Fit
from identify.fitting.parameter_layout import NOWHERE
from identify.fitting.problem import Problem
from identify.model.measured_path import states_along
from identify.model.simulate import Response, hermite
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay

_STEP = 1e-4


@dataclass(frozen=True, eq=False)
class Segment:
    """About one cycle: samples `start` to `stop` - 1 of the window are compared, the run begins at `begin`.

    `variation` holds what a change of the state at `begin` does to the whitened readings, shape (rows, 2), per
    natural size of displacement and velocity; `carry` (2, 2) what it does to the state where the next segment begins;
    `departure` is the state at `begin` and `arrival` that at the next one, in natural sizes.
    """

    begin: int
    start: int
    stop: int
    rows: slice
    variation: Array
    carry: Array
    departure: Array
    arrival: Array


@dataclass(frozen=True, eq=False)
class MultipleShooting:
    """The model run along one window, segment by segment.

    `displacement`, `velocity`, `acceleration` (n,) of the model, on the acceleration's clock and from the spring's
    zero; `misfit` (rows,) the whitened difference of the readings, segment after segment and in each channel after
    channel; `sizes` the natural displacement and velocity; `stiffness` and `damping` (per unit mass) of the linear part,
    and `step` its exact step, give the response of the readings to a small extra force.
    """

    window: FitWindow
    segments: tuple[Segment, ...]
    displacement: Array
    velocity: Array
    acceleration: Array
    misfit: Array
    sizes: tuple[float, float]
    frequency: float
    stiffness: float
    damping: float
    lag: float
    gain: float
    step: Array

    def without_states(self, rows: Array) -> Array:
        """Return whitened rows (rows, columns) less what the state at the start of each segment explains."""
        out = np.array(rows)
        for segment in self.segments:
            basis = np.linalg.qr(segment.variation)[0]
            part = out[segment.rows]
            out[segment.rows] = part - basis @ (basis.T @ part)
        return out


def rows_of(window: FitWindow, samples: slice, change: dict[str, Array]) -> Array:
    """Return changes of some samples' readings, (samples, ...) a channel, as whitened rows, channel after channel."""
    return np.concatenate([change[c][window.used[c][samples]] / window.sigma[c] for c in window.channels])


def shoot(prepared: PreparedDecay, fit: Fit) -> MultipleShooting:
    """Run a fitted model (of one window) along the measured motion, cycle by cycle."""
    window, motion = fit.windows[0], prepared.motion
    values = fit.of_release(0)
    aligned = prepared.alignment
    lag = aligned.lag.value if aligned is not None else 0.0
    gain = aligned.gain.value if aligned is not None else 1.0
    u = motion.displacement + prepared.zero - values.get("displacement_offset", prepared.zero)
    v = motion.velocity
    sizes = (float(np.max(np.abs(u))), float(np.max(np.abs(u))) * fit.frequency)
    pieces = _pieces(window, u, v, fit.frequency)
    problem, theta = _problem(fit, pieces, u, v)
    kept = {name: np.zeros(len(window)) for name in ("displacement", "velocity", "acceleration")}
    segments: list[Segment] = []
    misfits: list[Array] = []
    row = 0
    for i, (begin, start, stop) in enumerate(pieces):
        runs = _runs(problem, theta, i, sizes)
        seen = [_readings(run, window, lag, gain, values) for run in runs]
        misfit, variation = _whitened(window, pieces[i], seen)
        following = pieces[i + 1][0] if i + 1 < len(pieces) else stop - 1
        arrival, carry = _carried(runs, following - begin, sizes)
        departure = np.array([u[begin] / sizes[0], v[begin] / sizes[1]])
        first = begin if i == 0 else start
        for name, values_kept in kept.items():
            values_kept[first:stop] = getattr(runs[0], name)[first - begin : stop - begin]
        rows = slice(row, row + len(misfit))
        segments.append(Segment(begin, start, stop, rows, variation, carry, departure, arrival))
        misfits.append(misfit)
        row += len(misfit)
    stiffness, damping = _linear_part(fit)
    return MultipleShooting(
        window,
        tuple(segments),
        **kept,
        misfit=np.concatenate(misfits),
        sizes=sizes,
        frequency=fit.frequency,
        stiffness=stiffness,
        damping=damping,
        lag=lag,
        gain=gain,
        step=one_step(stiffness, damping, 1.0 / window.rate),
    )


def _linear_part(fit: Fit) -> tuple[float, float]:
    """Return linear stiffness (1/s^2) and damping (1/s) of a fitted model, by its frequency where it has no spring."""
    stiffness = fit.linear_strength(LinearPart.STIFFNESS)
    damping = fit.linear_strength(LinearPart.DAMPING)
    return fit.frequency**2 if stiffness is None else stiffness, 0.0 if damping is None else damping


def _runs(problem: Problem, theta: Array, i: int, sizes: tuple[float, float]) -> list[Response]:
    """Return the run of segment i, and those from a little more displacement and a little more velocity."""
    runs = [problem.respond(theta, i)]
    for place, size in zip(problem.layout.releases[i].start, sizes, strict=True):
        moved = theta.copy()
        moved[place] += _STEP * size
        runs.append(problem.respond(moved, i))
    return runs


def _whitened(
    window: FitWindow, piece: tuple[int, int, int], seen: list[dict[str, Array]]
) -> tuple[Array, Array]:
    """Return the misfit of a segment's run, (rows,), and what more displacement and velocity do to it, (rows, 2)."""
    begin, start, stop = piece
    samples, run = slice(start, stop), slice(start - begin, stop - begin)
    here = {c: values[run] for c, values in seen[0].items()}
    misfit = {c: window.readings[c][samples] - here[c] for c in window.channels}
    moved = {c: np.column_stack([(s[c][run] - here[c]) / _STEP for s in seen[1:]]) for c in window.channels}
    return rows_of(window, samples, misfit), rows_of(window, samples, moved)


def _carried(runs: list[Response], at: int, sizes: tuple[float, float]) -> tuple[Array, Array]:
    """Return the state after `at` samples, (2,), and what the state at the start does to it, (2, 2), in natural sizes."""
    states = [np.array([run.displacement[at] / sizes[0], run.velocity[at] / sizes[1]]) for run in runs]
    return states[0], np.column_stack([(state - states[0]) / _STEP for state in states[1:]])


def one_step(stiffness: float, damping: float, h: float) -> Array:
    """Return the exact step of x'' + c x' + k x = -force over `h` s, (2, 4).

    It takes x, x', the force and its rise over the step, in which the force is linear.
    """
    from scipy.linalg import expm  # loaded when it is needed

    generator = np.zeros((4, 4))
    generator[0, 1] = h
    generator[1, :3] = -stiffness * h, -damping * h, -h
    generator[2, 3] = 1.0
    return np.asarray(expm(generator)[:2])


def _pieces(window: FitWindow, u: Array, v: Array, frequency: float) -> list[tuple[int, int, int]]:
    """Return (begin, start, stop) of each segment: from one rising passage of the middle to the next."""
    n = len(u)
    turns = np.unwrap(np.arctan2(u, v / frequency)) / (2.0 * np.pi)
    turns = np.maximum.accumulate(turns)
    edges = np.flatnonzero(np.diff(np.floor(turns)) > 0) + 1
    period = 2.0 * np.pi / frequency * window.rate
    edges = edges[(edges > window.lead + 0.5 * period) & (edges < n - 0.5 * period)]
    bounds = [window.lead, *[int(e) for e in edges], n]
    return [(start - window.lead, start, stop) for start, stop in pairwise(bounds)]


def _problem(fit: Fit, pieces: list[tuple[int, int, int]], u: Array, v: Array) -> tuple[Problem, Array]:
    """Return the model on one short window a segment, and the unknowns at which it runs along the measured motion."""
    window = fit.windows[0]
    reach = window.lead + 2
    windows = tuple(
        _short(window, begin, min(stop + reach, len(window) + reach)) for begin, _, stop in pieces
    )
    problem = Problem(fit.model, windows, fit.frequency)
    values = fit.of_release(0)
    theta = problem.theta(values)
    memories = [states_along(term, values, window.clock, u, v) for term in problem.layout.forces]
    for (begin, _, _), places in zip(pieces, problem.layout.releases, strict=True):
        theta[list(places.start)] = u[begin], v[begin]
        if places.lag != NOWHERE:
            theta[places.lag] = 0.0
        for cell in places.states:
            theta[cell.unknown] = memories[cell.row][begin, cell.column]
    return problem, theta


def _short(window: FitWindow, begin: int, end: int) -> FitWindow:
    """Return samples `begin` to `end` - 1 of a window, held on beyond its end."""
    take = np.minimum(np.arange(begin, end), len(window) - 1)
    return window.with_(
        time=window.time + begin / window.rate,
        readings={c: r[take] for c, r in window.readings.items()},
        used={c: m[take] for c, m in window.used.items()},
        force=None if window.force is None else window.force[take],
    )


def _readings(
    run: Response, window: FitWindow, lag: float, gain: float, values: dict[str, float]
) -> dict[str, Array]:
    """Simulate the sensors' readings of a run without faults: lag, gain and offsets applied."""
    u, v = delayed(run.displacement, run.velocity, run.acceleration, lag, window.rate)
    seen = {"displacement": u, "velocity": v, "acceleration": gain * run.acceleration}
    return {c: seen[c] + values.get(f"{c}_offset", 0.0) for c in window.channels}


def delayed(u: Array, v: Array, a: Array, lag: float, rate: float) -> tuple[Array, Array]:
    """Return displacement and velocity read `lag` s before each sample, by the quintic Hermite polynomial."""
    if lag == 0.0:
        return u, v
    n = len(u)
    place = np.arange(n) - lag * rate
    i = np.clip(np.floor(place).astype(int), 0, n - 2)
    both_ends = (u[i], v[i], a[i], u[i + 1], v[i + 1], a[i + 1])
    moved, slope = hermite.py_func(place - i, 1.0 / rate, *both_ends)
    return np.asarray(moved), np.asarray(slope)
