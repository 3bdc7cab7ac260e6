"""The extra force: the size of a force of given pattern that would explain the residual of the tracked model."""

import numpy as np

from identify.arrays import Array
from identify.comparison.multiple_shooting import MultipleShooting, Segment, rows_of
from identify.compilation import compiled


def estimate_extra_force(shooting: MultipleShooting, patterns: Array) -> tuple[Array, Array, float]:
    """Fit the residual of the tracked model by its response to patterns (n, patterns) of force (least squares).

    Returns the sizes of the patterns (patterns,), m/s^2 on the left of u'' + ... = 0, their covariance, and the reduced
    chi-square that they leave within the cycles. The state at the start of every stretch is free, and so are lag, gain
    and offset of the acceleration, which kinematics alone determines. A pattern that the readings do not feel has a
    standard error as large as the springs' force.
    """
    columns = np.hstack([_respond_to(shooting, patterns), nuisances(shooting)])
    both = shooting.without_states(np.column_stack([columns, shooting.misfit]))
    columns, misfit = both[:, :-1], both[:, -1]
    count = patterns.shape[1]
    largest = shooting.stiffness * shooting.sizes[0]
    prior = np.full(columns.shape[1], 1.0)
    prior[:count] = 1.0 / largest**2
    normal = columns.T @ columns
    scale = np.sqrt(np.diag(normal) + prior)
    inverse = np.linalg.inv((normal + np.diag(prior)) / np.outer(scale, scale)) / np.outer(scale, scale)
    gradient = columns.T @ misfit
    size = inverse @ gradient
    left = float(misfit @ misfit - gradient @ size)
    degrees = len(misfit) - 2 * len(shooting.segments) - columns.shape[1]
    return size[:count], inverse[:count, :count], left / max(degrees, 1)


def _respond_to(shooting: MultipleShooting, patterns: Array) -> Array:
    """Return the whitened change of the readings (rows, patterns) under extra forces (n, patterns), per m/s^2."""
    out = np.empty((len(shooting.misfit), patterns.shape[1]))
    for segment in shooting.segments:
        x, v = _filtered(shooting.step, patterns[segment.begin : segment.stop])
        out[segment.rows] = _seen(shooting, segment, x, v, patterns[segment.begin : segment.stop])
    return out


def respond_in(
    shooting: MultipleShooting, segment: Segment, patterns: Array, until: int
) -> tuple[Array, Array]:
    """Compute the response to forces (samples of the stretch, patterns) from its beginning on.

    The whitened change of the readings (rows of the stretch, patterns), and the change of displacement and velocity
    at sample `until`, in natural sizes, (2, patterns).
    """
    x, v = _filtered(shooting.step, patterns)
    at = until - segment.begin
    end = np.vstack([x[at] / shooting.sizes[0], v[at] / shooting.sizes[1]])
    return _seen(shooting, segment, x, v, patterns), end


def _seen(shooting: MultipleShooting, segment: Segment, x: Array, v: Array, patterns: Array) -> Array:
    """Return the whitened change of a segment's readings by a small change of displacement and velocity."""
    seen = slice(segment.start - segment.begin, None)
    x, v = x[seen], v[seen]
    a = -patterns[seen] - shooting.damping * v - shooting.stiffness * x
    lag, window = shooting.lag, shooting.window
    change = {
        "displacement": x - lag * v + 0.5 * lag * lag * a,
        "velocity": v - lag * a,
        "acceleration": a * shooting.gain,
    }
    return rows_of(window, slice(segment.start, segment.stop), change)


def nuisances(shooting: MultipleShooting) -> Array:
    """Whitened columns of lag, gain and the acceleration's offset, each in a natural size; none for a single channel."""
    window = shooting.window
    n = len(window)
    if not window.paired:
        return np.zeros((len(shooting.misfit), 0))
    change = {channel: np.zeros((n, 3)) for channel in window.channels}
    if "displacement" in change:
        change["displacement"][:, 0] = -shooting.velocity * 1e-2 / shooting.frequency
    if "velocity" in change:
        change["velocity"][:, 0] = -shooting.acceleration * 1e-2 / shooting.frequency
    change["acceleration"][:, 1] = shooting.acceleration * 1e-2
    change["acceleration"][:, 2] = 1e-2 * shooting.stiffness * shooting.sizes[0]
    parts = (slice(segment.start, segment.stop) for segment in shooting.segments)
    return np.concatenate([rows_of(window, p, {c: x[p] for c, x in change.items()}) for p in parts])


@compiled(nogil=True, error_model="numpy")
def _filtered(step, pattern):  # type: ignore[no-untyped-def]
    x, v = np.zeros(pattern.shape), np.zeros(pattern.shape)
    for i in range(pattern.shape[0] - 1):
        for j in range(pattern.shape[1]):
            force = pattern[i, j]
            rise = pattern[i + 1, j] - force
            x[i + 1, j] = step[0, 0] * x[i, j] + step[0, 1] * v[i, j] + step[0, 2] * force + step[0, 3] * rise
            v[i + 1, j] = step[1, 0] * x[i, j] + step[1, 1] * v[i, j] + step[1, 2] * force + step[1, 3] * rise
    return x, v
