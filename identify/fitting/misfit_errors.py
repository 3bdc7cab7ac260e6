"""Standard errors from the actual misfit, not from the noise alone.

Where a model leaves more than noise, its parameters err by what the misfit does where their columns lie: at the
frequency of the motion. There it drifts slowly beside the motion, in amplitude and phase; in each cycle two numbers hold
that, along an orthonormal pair of the modelled motion's cosine and sine. What lies elsewhere counts as white noise of its
mean density.

A fit hides of its misfit what its parameters can follow, which is just what moves them. What is left shows the rest of
the same process, so its strength and correlation are measured by restricted likelihood (Patterson and Thompson 1971),
which knows what was hidden. With few cycles they stay unsure; so the parameters' variance is the mean over all that the
residual allows, and not the variance at the likeliest.

A rig changes between releases, and a law that is not quite right has other constants at other amplitudes. No single
release shows it. Where the values of single releases scatter by more than their errors, the error of all together is
raised by the ratio, as the Particle Data Group averages measurements (Rosenfeld et al., Rev. Mod. Phys. 39, 1, 1967).
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask
from identify.effects.families import FAMILY_OF
from identify.fitting.fit import Fit, fit
from identify.model.model import Term
from identify.model.simulate import Response
from identify.preprocessing.fit_window import FitWindow
from identify.priors import CLEAR

_FEWEST = 6
"""Readings in a cycle; one with fewer has no say."""

_INDEPENDENT = 0.1
"""Share of a sine's square that must be independent of the cosine, so that a part of a cycle has two numbers."""


@dataclass(frozen=True, eq=False)
class CycleSums:
    """One channel of one window, in units of its noise, cycle by cycle.

    `residual` (2, cycles) along cosine and sine, `columns` (own, 2, cycles) of the Jacobian for the unknowns at `places`
    (own,); `amplitude` (cycles,) is that of the motion times the root of the readings, `position` (cycles,) counts cycles.
    `square` and `readings` are the sum of squares and the number of all readings.
    """

    window: int
    places: NDArray[np.int_]
    residual: Array
    columns: Array
    amplitude: Array
    position: Array
    square: float
    readings: int

    @property
    def products(self) -> Array:
        """The products of the columns with one another, (own, own)."""
        return np.asarray(np.einsum("pak,qak->pq", self.columns, self.columns))


def cycle_sums(found: Fit, scales: Array) -> tuple[CycleSums, ...]:
    """Sum all channels of all windows of a fit cycle by cycle, for steps of its unknowns by `scales` (unknowns,).

    Unknowns whose scale is 0 are left out; places are among the others.
    """
    jacobian, sums = found.linearised[1], []
    among = np.cumsum(scales > 0.0) - 1
    for i, (window, motion) in enumerate(zip(found.windows, found.problem.motions(found.theta), strict=True)):
        own = scales[jacobian.pattern.places[i]] > 0.0
        at, first = jacobian.pattern.places[i][own], 0
        for channel in window.channels:
            used = window.used[channel]
            misfit = window.compared(channel, found.residual(channel, i))
            rows = scales[at, None] * jacobian.blocks[i][own, first : first + len(misfit)]
            first += len(misfit)
            summed = _summed(*_rotation(motion.response, found.frequency, used), misfit, rows)
            if summed is not None:
                sums.append(CycleSums(i, among[at], *summed, float(misfit @ misfit), len(misfit)))
    return tuple(sums)


def _rotation(response: Response, frequency: float, used: Mask) -> tuple[Array, Array]:
    """Return phase (rad) and amplitude of a motion at the readings that are used."""
    quarter = response.velocity / frequency
    phase = np.maximum.accumulate(np.unwrap(np.arctan2(-quarter, response.displacement)))
    return phase[used], np.hypot(response.displacement, quarter)[used]


def _summed(
    phase: Array, amplitude: Array, misfit: Array, rows: Array
) -> tuple[Array, Array, Array, Array] | None:
    """Return residual, columns, amplitude and position of each cycle; None where there is no whole one."""
    if not len(phase) or not np.isfinite(phase).all() or not np.isfinite(misfit).all():
        return None
    turns = (phase - phase[0]) / (2.0 * np.pi)
    starts = np.flatnonzero(np.diff(np.floor(turns), prepend=-1.0))

    def sums(values: Array) -> Array:
        return np.asarray(np.add.reduceat(values, starts, axis=-1))

    cosine, sine = np.cos(phase), np.sin(phase)
    count, cc, cs, ss = sums(np.ones_like(phase)), sums(cosine**2), sums(cosine * sine), sums(sine**2)
    left = ss - cs**2 / np.maximum(cc, 1e-300)
    kept = (count >= _FEWEST) & (left > _INDEPENDENT * ss) & (cc > _INDEPENDENT * ss)
    if not kept.any():
        return None
    root, rest, tilt = np.sqrt(cc[kept]), np.sqrt(left[kept]), (cs / np.maximum(cc, 1e-300))[kept]

    def along(values: Array) -> Array:
        even, odd = sums(values * cosine)[..., kept], sums(values * sine)[..., kept]
        return np.stack([even / root, (odd - tilt * even) / rest], axis=-2)

    size = sums(amplitude)[kept] / np.sqrt(count[kept])
    return along(misfit), along(rows), size, (sums(turns) / count)[kept]


_TIMES = 6
"""Correlation times that are tried, from one cycle to the longest window."""

_POWERS = (0.0, 1.0)
"""Of the amplitude, in the size of the misfit: another motion beside this one, or a random walk of this one."""

_STRENGTHS = np.concatenate([[0.0], np.geomspace(0.1, 1e6, 9)])
"""Variance of the process in one cycle over that of white noise."""

_BEFORE = np.where(_STRENGTHS > 0.0, 0.5 / (len(_STRENGTHS) - 1), 0.5)
"""Weight of each strength before the residual is seen: white noise has as much as all processes."""

_FEWEST_FREE = 3
"""Numbers beyond the parameters, from which on a variance can be measured."""

_RANK = 1e-10


def scatter_of_scores(sums: Sequence[CycleSums], p: int, windows: int) -> Array | None:
    """Estimate the covariance of J'e from the residual, by window, in units of the noise, (windows, p, p).

    Of p unknowns, and of what lies at the motion's frequency; e is the misfit before the fit. None where there are too
    few cycles.
    """
    if not sums:
        return None
    longest = max(np.ptp(one.position) for one in sums)
    trials = [
        _trial(sums, p, time, power)
        for power in _POWERS
        for time in np.geomspace(1.0, max(longest, 2.0), _TIMES)
    ]
    likelihood, variance = (np.array([trial[k] for trial in trials]) for k in (0, 1))
    if not np.isfinite(likelihood).any():
        return None
    weight = _BEFORE * np.exp(likelihood - likelihood.max())
    weight /= weight.sum()
    white, process = (weight * np.maximum(variance, 1.0)).sum(), (weight * variance) @ _STRENGTHS
    total = np.zeros((windows, p, p))
    for k, one in enumerate(sums):
        products = white * one.products
        products += sum(share * trial[2][k] for share, trial in zip(process, trials, strict=True))
        total[one.window][np.ix_(one.places, one.places)] += products
    return total


def _trial(sums: Sequence[CycleSums], p: int, time: float, power: float) -> tuple[Array, Array, list[Array]]:
    """Weigh all strengths of a process that keeps for a `time` (cycles), by restricted likelihood over p unknowns.

    Log-likelihoods and variances of the white part, (strengths,) each, and for each of the sums the products (own, own) of
    its columns under the process of strength 1.
    """
    mean = np.sqrt(np.mean(np.concatenate([one.amplitude for one in sums]) ** 2))
    channels = len(sums) / len({one.window for one in sums})
    products, along = np.zeros((len(_STRENGTHS), p, p)), np.zeros((len(_STRENGTHS), p))
    square, determinant = np.zeros(len(_STRENGTHS)), np.zeros(len(_STRENGTHS))
    process = []
    for one in sums:
        scale = (one.amplitude / mean) ** power
        apart = np.sqrt(3.0) * np.abs(np.subtract.outer(one.position, one.position)) / time
        sizes, vectors = np.linalg.eigh((1.0 + apart) * np.exp(-apart) * np.outer(scale, scale))
        sizes = np.maximum(np.tile(sizes, 2), 0.0)
        columns = (one.columns @ vectors).reshape(len(one.places), -1)
        residual = (one.residual @ vectors).ravel()
        process.append(channels * (columns * sizes) @ columns.T)  # channels misfit together
        spread = 1.0 + _STRENGTHS[:, None] * sizes
        weighted = columns / spread[:, None, :]
        products[:, one.places[:, None], one.places] += weighted @ columns.T
        along[:, one.places] += weighted @ residual
        square += (residual**2 / spread).sum(axis=1)
        determinant += np.log(spread).sum(axis=1)
    values, vectors = np.linalg.eigh(products)
    kept = values > _RANK * values[:, -1:]
    followed = np.einsum("qpk,qp->qk", vectors, along) ** 2
    square -= np.divide(followed, values, out=np.zeros_like(values), where=kept).sum(axis=1)
    square = np.maximum(square, 1e-300)
    determinant += np.log(values, out=np.zeros_like(values), where=kept).sum(axis=1)
    left = sum(one.residual.size for one in sums) - kept.sum(axis=1)
    enough = left >= _FEWEST_FREE
    likelihood = np.where(enough, -0.5 * (left * np.log(square) + determinant), -np.inf)
    # raised as the variance of Student's distribution is by few degrees of freedom
    return likelihood, np.where(enough, square / np.maximum(left - 2, 1), 1.0), process


_PRECISE = 3.0
"""Errors above so many times that of the mean, times the root of the number of releases, have no say in the ratio."""

_UNDETERMINED = 1e-2
"""Share of a parameter that lies in directions which a release does not determine, from which on it has no say."""


def spread_of_releases(
    windows: tuple[FitWindow, ...], cycles: tuple[CycleSums, ...], scatter: Array, std: Array
) -> Array:
    """Return the factor, 1 at least, by which the spread of releases raises the standard error of each unknown, (p,).

    `cycles` are the sums of all `windows`; `scatter` (windows, p, p) is that of the scores, `std` (p,) the errors from the
    misfit. The value of a single release is that of one Gauss-Newton step from the fit of all.
    """
    release = np.array([window.release for window in windows])
    each = [_alone(cycles, scatter, release == one) for one in np.unique(release)]
    values, errors = (np.array(parts) for parts in zip(*each, strict=True))
    counted = np.isfinite(errors) & (errors < _PRECISE * np.sqrt(len(each)) * std)
    weight = np.where(counted, 1.0 / errors**2, 0.0)
    mean = (weight * values).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-300)
    square = (weight * (values - mean) ** 2).sum(axis=0) / np.maximum(counted.sum(axis=0) - 1, 1)
    return np.asarray(np.sqrt(np.maximum(square, 1.0)))


def _alone(cycles: tuple[CycleSums, ...], scatter: Array, own: Mask) -> tuple[Array, Array]:
    """Return the change of each unknown when only the windows marked `own` count, and its error there, (p,)."""
    p = scatter.shape[1]
    normal, gradient = np.zeros((p, p)), np.zeros(p)
    for one in cycles:
        if own[one.window]:
            normal[np.ix_(one.places, one.places)] += one.products
            gradient[one.places] += np.einsum("pak,ak->p", one.columns, one.residual)
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal / np.outer(size, size))
    seen = values > _RANK * values[-1]
    lost = (vectors[:, ~seen] ** 2).sum(axis=1) > _UNDETERMINED
    inverse = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T / np.outer(size, size)
    variance = np.einsum("ij,jk,ki->i", inverse, scatter[own].sum(axis=0), inverse)
    return -inverse @ gradient, np.where(lost, np.inf, np.sqrt(np.maximum(variance, 1e-300)))


_REACH = 0.5
"""Distance, in units of the motion's frequency, up to which a bin counts."""


def with_misfit_errors(found: Fit, held: Collection[str] = ()) -> Fit:
    """Give a fit the covariance of least squares under its actual misfit, never below that of the noise.

    The sandwich of normal matrix and scatter of the scores (Huber 1967). Unknowns whose names are `held` were not fitted.
    """
    fitted = np.array([name not in held for name in found.names])
    length = np.sqrt(np.diag(found.linearised[1].normal())) * fitted
    scales = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)
    cycles, free = cycle_sums(found, scales), np.flatnonzero(scales)
    scatter = scatter_of_scores(cycles, len(free), len(found.windows))
    if scatter is None:  # white noise as dense as the misfit is all that can be said
        return with_covariance(found, found.covariance * max(misfit_density(found), 1.0))
    density, beyond = _density_elsewhere(cycles), scatter.sum(axis=0)
    for one in cycles:
        beyond[np.ix_(one.places, one.places)] -= density * one.products
    own = np.ix_(free, free)
    inverse = found.covariance[own] / np.outer(scales[free], scales[free])
    covariance = inverse * density + inverse @ beyond @ inverse
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    raised = spread_of_releases(found.windows, cycles, scatter, std)
    whole = found.covariance * density
    whole[own] = covariance * np.outer(raised * scales[free], raised * scales[free])
    return with_covariance(found, whole)


def with_covariance(found: Fit, covariance: Array) -> Fit:
    """Replace the covariance of a fit's unknowns; the squares of its standard errors grow by the difference."""
    values, more = {}, np.diag(covariance) - np.diag(found.covariance)
    for name, extra in zip(found.names, more.tolist(), strict=True):
        before = found.values[name]
        values[name] = replace(before, std=float(np.sqrt(max(before.std**2 + extra, 0.0))))
    return replace(found, covariance=covariance, values=values)


def _density_elsewhere(cycles: tuple[CycleSums, ...]) -> float:
    """Return the mean square of the residual off the motion's frequency, in units of the noise; 1 at least."""
    square = sum(one.square - float((one.residual**2).sum()) for one in cycles)
    return max(square / max(sum(one.readings - one.residual.size for one in cycles), 1), 1.0)


def misfit_density(found: Fit, around: float | None = None, channel: str = "") -> float:
    """Estimate the spectral density of the residual around the motion's frequency, in units of that of the noise.

    Or `around` another angular frequency (rad/s), within half the motion's; of one `channel`, or of all.
    """
    power, count = 0.0, 0
    centre = found.frequency if around is None else around
    for i, window in enumerate(found.windows):
        for name in (channel,) if channel else window.channels:
            residual = found.in_noise(name, i)
            spectrum = np.abs(np.fft.rfft(residual)) ** 2 / max(int(window.used[name].sum()), 1)
            omega = np.fft.rfftfreq(len(window), 1.0 / window.rate) * 2.0 * np.pi
            near = np.abs(omega - centre) < _REACH * found.frequency
            power += float(spectrum[near].sum())
            count += int(near.sum())
    return power / max(count, 1)


def is_clear(whole: Fit, term: Term) -> bool:
    """Check whether the strength of an effect differs from zero by some errors of the actual misfit.

    Of one that beats with the motion, and did not begin at rest, only the product of strength and states shows: the states
    are held. Farther off, such a line is another mode unless the strength itself is clear. The free constant of a family's
    law is held, as its members hold it: the nearer the law is to a spring or a damper, the less its strength shows alone.
    """
    effect, held = term.force, list[str]()
    values = np.array([estimate.value for estimate in whole.of(term, 0).values()])
    if effect.beats_with is not None and effect.beats_with(values, whole.frequency):
        held = [u.name for u in whole.unknowns if u.id.role == "state" and u.id.effect == effect.name]
    if effect in FAMILY_OF:
        held.append(str(term.parameter(FAMILY_OF[effect].free)))
    if held:
        whole = fit(whole.model, whole.windows, whole.point, whole.frequency, near=True, held=held)
    strength = with_misfit_errors(whole, held).values[str(term.strength)]
    return bool(np.isfinite(strength.std) and abs(strength.value) > CLEAR * strength.std)
