"""The restoring force surface, eqs. (13)-(19)."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array, Mask, frozen
from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.free_decay import FreeDecay
from identify.motion import Motion, reconstruct
from identify.noise import noise_of
from identify.orders import choose_order
from identify.oscillation import dominant_frequency
from identify.smoothing import slope, smooth
from identify.spikes import without_spikes
from identify.spread import correlated_covariance, misfit_covariance
from identify.surface import Polynomial, Section, grid_of, sections_of
from identify.units import damping_unit, stiffness_unit
from identify.usable import first_free_sample, last_large_sample, require_cycles, valid_samples
from identify.weak_form import (
    LeastSquares,
    Windows,
    averaged_sign,
    band_of,
    band_of_reversals,
    direction_of,
    factor_of,
    place_windows,
    refine_reversals,
    rows_of,
    solve,
    whiten,
    widened,
)

__all__ = [
    "RestoringForceResult",
    "Section",
    "identify_restoring_force",
    "identify_restoring_force_as_recorded",
]

CHANNELS = ("displacement", "velocity", "acceleration")
_FEWEST_CYCLES = 3.5  # windows of two cycles, and room to slide them
_STOP_AT_DRY_ZONE = 2.5  # as in the wavelet identification
_STOP_AT_NOISE = 6.0
_REACH = 2  # samples from a reversal over which the friction's jump is smeared
_CALM_HARMONICS = 8.0  # kept of a coarse displacement, times the natural frequency
_ROUGH = 0.2  # of the acceleration, beyond which it is mostly noise
_MISFIT = 2.0  # chi-square per degree beyond which noise alone does not explain what is left
_SHARES = (0.0, 1e-4, 1e-3, 1e-2)  # of a missing force in what is left; more would throw the resonance away
_FALL = 0.995  # of the lower order's misfit: there are many rows, and most hold no damping
_SURE_SIGN = 3.0  # standard errors of the velocity below which its sign is noise


@dataclass(frozen=True, eq=False)
class RestoringForceResult:
    """What the restoring force surface says.

    `stiffness` is K (N/m with a mass, 1/s^2 without); `damping` holds mu_i per unit mass by order
    i = 0..`order` (0 is sgn v); `stiffness_by_order` every displacement order that was kept; `offset` the
    constant force per unit mass. `mse_percent_by_order` is eq. (18) for damping orders 0..max (fig. 3b),
    `significance_percent` eq. (19) by term name. Points used, shape (n,): `time` (s, on the record's
    clock), `displacement`, `velocity`, `force` (per unit mass, eq. 14) and `force_fit`. The surface on a grid:
    `grid_displacement` (p,), `grid_velocity` (q,), `surface` (q, p) fitted, `visited` (q, p) counts of points.
    Sections at v = 0 and u = 0. `stiffness_per_mass` (1/s^2) leaves the mass's uncertainty out. `mass` is what a
    recorded force says of the mass, in the force's unit over m/s^2, when none was given; None otherwise.
    """

    stiffness: Estimate
    stiffness_by_order: dict[int, Estimate]
    damping: tuple[Estimate, ...]
    offset: Estimate
    order: int
    reason: str
    mse_percent: float
    mse_percent_by_order: tuple[float, ...]
    significance_percent: dict[str, float]
    source: str
    time: Array
    displacement: Array
    velocity: Array
    force: Array
    force_fit: Array
    grid_displacement: Array
    grid_velocity: Array
    surface: Array
    visited: Array
    section_zero_velocity: Section
    section_zero_displacement: Section
    stiffness_per_mass: Estimate
    mass: Estimate | None = None


@dataclass(frozen=True, eq=False)
class _Span:
    """The part of the motion that identifies, with the spectra of its noise and the recorded force."""

    motion: Motion
    first: int
    stop: int
    valid: Mask
    angular_frequency: float
    force: Array | None
    noise: tuple[tuple[str, Callable[[Array], Array]], ...]

    def cut(self, values: Array) -> Array:
        return values[self.first : self.stop]


@dataclass(frozen=True, eq=False)
class _Fit:
    """Eq. (17) solved for one damping order; `clear` is how many standard errors its highest
    damping stands from zero."""

    order: int
    solution: LeastSquares
    clear: float
    covariance: Array
    polynomial: Polynomial
    force_gain: float


def identify_restoring_force(
    decay: FreeDecay, max_order: int = 3, stiffness_orders: tuple[int, ...] = (1,)
) -> RestoringForceResult:
    """Identify the restoring force of a decay whose channels are aligned.

    `max_order` is the highest order of damping tried, `stiffness_orders` the displacement orders of eq. (15).
    With a recorded `force` the equation is driven (eq. 14): as force per unit mass where the mass is known, else
    with one more unknown, 1/m. Since the motion's parts agree with each other whatever small lag is left,
    the lag's standard error adds nothing here; see `identify_restoring_force_as_recorded` for what it does
    otherwise. Raises NotIdentifiable when there is too little to identify.
    """
    decay = without_spikes(decay)
    motion = _calmed(reconstruct(decay))
    return _identify(decay, motion, _noise_of_agreeing(decay), max_order, stiffness_orders)


def identify_restoring_force_as_recorded(
    decay: FreeDecay, max_order: int = 3, stiffness_orders: tuple[int, ...] = (1,)
) -> RestoringForceResult:
    """Identify the restoring force from displacement and acceleration as they are, each taken at its word.

    The paper's first attempt: a displacement late by tau adds w0^2 tau to mu_1. Raises NotIdentifiable
    without both channels.
    """
    if decay.displacement is None or decay.acceleration is None:
        raise NotIdentifiable("the restoring force as recorded needs a displacement and an acceleration")
    after = slice(decay.release, None)
    displacement, acceleration = decay.displacement[after], decay.acceleration[after]
    motion = Motion(
        decay.rate,
        decay.release,
        frozen(displacement),
        frozen(slope(displacement, decay.rate)),
        frozen(acceleration),
        valid_samples(decay)[after],
        "displacement and acceleration, as recorded",
    )
    levels = _levels(decay)
    noise = (
        ("elastic", lambda w: np.full_like(w, levels["displacement"] ** 2)),
        ("inertial", lambda w: np.full_like(w, levels["acceleration"] ** 2)),
    )
    return _identify(decay, motion, noise, max_order, stiffness_orders)


def _identify(
    decay: FreeDecay,
    motion: Motion,
    noise: tuple[tuple[str, Callable[[Array], Array]], ...],
    max_order: int,
    stiffness_orders: tuple[int, ...],
) -> RestoringForceResult:
    span = _span_of(decay, motion, noise)
    windows = place_windows(span.valid, motion.rate, span.angular_frequency)
    if 2 * len(windows.first) < max_order + len(stiffness_orders) + 4:
        raise NotIdentifiable("gaps leave too few whole stretches of two cycles; record again without losses")
    points = _points(span)
    fits = _fits(span, windows, max_order, stiffness_orders, decay)
    clear = [fit.clear for fit in fits]
    import os

    if os.environ.get("DBG"):
        print(
            "   clear",
            np.round(clear, 1),
            "chi",
            [round(f.solution.chi_square, 3) for f in fits],
            [np.round(f.polynomial.damping, 5) for f in fits],
        )
    misfits = [fit.solution.chi_square for fit in fits]
    worth = [_FALL] * len(fits)
    order, reason = choose_order(range(max_order + 1), misfits, clear, worth, "damping")
    return _result(decay, span, fits, fits[order], reason, points)


def _calmed(motion: Motion) -> Motion:
    """Smooth a motion whose acceleration is mostly noise, as two differentiations of a coarse displacement leave it."""
    frequency = dominant_frequency(motion.velocity, motion.rate)
    corner = _CALM_HARMONICS * frequency / motion.rate
    if motion.source != "displacement" or not 0 < corner < 0.3:
        return motion
    displacement = smooth(motion.displacement, corner, motion.valid)
    velocity = slope(displacement, motion.rate)
    acceleration = slope(velocity, motion.rate)
    rough = np.mean((motion.acceleration - acceleration)[motion.valid] ** 2)
    if rough < _ROUGH**2 * np.mean(acceleration[motion.valid] ** 2):
        return motion
    return replace(
        motion, displacement=displacement, velocity=velocity, acceleration=acceleration, noise_velocity=None
    )


def _levels(decay: FreeDecay) -> dict[str, float]:
    present = [name for name in CHANNELS if getattr(decay, name) is not None]
    levels = {name: getattr(decay, f"noise_{name}") for name in present}
    if not all(levels.values()):
        measured = noise_of(decay)
        levels = {name: level or measured[name].std for name, level in levels.items()}
    return {
        name: max(level, 1e-9 * float(np.nanstd(getattr(decay, name))), 1e-300)
        for name, level in levels.items()
    }


def _noise_of_agreeing(decay: FreeDecay) -> tuple[tuple[str, Callable[[Array], Array]], ...]:
    """Variance by frequency of the displacement that all channels together give."""
    powers = {"displacement": 0, "velocity": 2, "acceleration": 4}
    levels = _levels(decay)
    if "displacement" in levels:
        levels.pop("velocity", None)  # the motion is made without it

    def spectrum(w: Array) -> Array:
        information = sum(w ** powers[name] / level**2 for name, level in levels.items())
        return np.asarray(1 / information)

    return (("consistent", spectrum),)


def _span_of(
    decay: FreeDecay, motion: Motion, noise: tuple[tuple[str, Callable[[Array], Array]], ...]
) -> _Span:
    finite = (
        np.isfinite(motion.displacement) & np.isfinite(motion.velocity) & np.isfinite(motion.acceleration)
    )
    valid = motion.valid & finite
    frequency = dominant_frequency(motion.velocity, motion.rate)
    if frequency <= 0:
        raise NotIdentifiable("no oscillation stands out of the motion; release from a larger amplitude")
    w = 2 * np.pi * frequency
    force = None if decay.force is None else decay.force[motion.start :]
    first = 0 if force is not None else max(0, first_free_sample(decay, frequency) - motion.start)
    stop = len(valid)
    require_cycles(stop - first, motion.rate, frequency, _FEWEST_CYCLES)
    span = _Span(motion, first, stop, valid[first:stop], w, force, noise)
    if force is not None:
        return span
    cycle = max(3, int(motion.rate / frequency))
    speed = np.where(valid, np.abs(motion.velocity), 0.0)[first:]
    largest = np.max(np.lib.stride_tricks.sliding_window_view(np.pad(speed, (0, cycle)), cycle), axis=1)
    envelope = largest[: len(speed)] / w
    quiet = _STOP_AT_NOISE * float(np.sqrt(noise[0][1](np.array([w]))[0]))
    dry = 0.04 * float(np.max(envelope))
    for _ in range(2):
        stop = first + last_large_sample(envelope, max(quiet, _STOP_AT_DRY_ZONE * dry))
        stop = min(max(stop, first + int(_FEWEST_CYCLES * motion.rate / frequency) + 1), len(valid))
        span = _Span(motion, first, stop, valid[first:stop], w, None, noise)
        dry = max(0.0, _dry_friction(span)) / w**2
    stop = first + last_large_sample(envelope, max(quiet, _STOP_AT_DRY_ZONE * dry))
    stop = min(max(stop, first + int(_FEWEST_CYCLES * motion.rate / frequency) + 1), len(valid))
    return _Span(motion, first, stop, valid[first:stop], w, None, noise)


def _dry_friction(span: _Span) -> float:
    """Plain least squares of eq. (15) of first order: a first value for mu_0."""
    u, v, a = (
        span.cut(x) for x in (span.motion.displacement, span.motion.velocity, span.motion.acceleration)
    )
    columns = np.stack([np.sign(v), v, u, np.ones_like(u)], axis=1)[span.valid]
    scale = np.linalg.norm(columns, axis=0) + 1e-300
    return float((np.linalg.lstsq(columns / scale, -a[span.valid], rcond=None)[0] / scale)[0])


def _fits(
    span: _Span, windows: Windows, max_order: int, stiffness_orders: tuple[int, ...], decay: FreeDecay
) -> list[_Fit]:
    """Solve eq. (17) for every damping order, with one covariance of the rows.

    A first solution of first order says how large the friction's jump is and where the resonance lies.
    """
    motion, w = span.motion, span.angular_frequency
    u, v, a = (span.cut(x) for x in (motion.displacement, motion.velocity, motion.acceleration))
    force = None if span.force is None else span.cut(span.force)
    unknown_mass = force is not None and decay.mass is None
    others = [u**j for j in stiffness_orders] + [np.ones_like(u)] + ([-force] if unknown_mass else [])
    powers = [np.abs(v) ** i * np.sign(v) for i in range(1, max(max_order, 1) + 1)]
    consistent = span.noise[0][0] == "consistent"

    def rows(sign: Array) -> Array:
        pull = np.zeros_like(u) if force is None or unknown_mass else force
        sums = rows_of(windows, windows.kernel, np.stack([sign, *powers, *others, pull - a]))
        if consistent:  # phi vanishes at its ends, so derivatives may pass from the motion to the window
            centred = (u - np.mean(u))[None]
            sums[:, -1:] = rows_of(windows, windows.kernel, pull[None])
            sums[:, -1:] -= rows_of(windows, windows.curvature, centred)
            sums[:, 1:2] = -rows_of(windows, windows.slope, centred)
        return sums

    direction = direction_of(v)
    factor = factor_of(_covariance(span, windows, 0.0, w**2))
    first = _solved(rows(averaged_sign(direction)), factor, 1, len(others))
    mu_0, mu_1, k_1 = first.values[0], first.values[1], first.values[2] if 1 in stiffness_orders else w**2

    direction = refine_reversals(v, direction, max(mu_0, 0.0), motion.rate, w)
    band = _covariance(span, windows, mu_1, k_1)
    band += band_of_reversals(windows, len(band), direction, 2 * mu_0, v, _noise_velocity(span))
    found = rows(averaged_sign(direction))
    best = _solved(found, factor_of(band), max(max_order, 1), len(others))
    misfit = best.chi_square > _MISFIT
    if misfit:
        band = band + _equation_error(span, windows, found, band, max(max_order, 1), len(others))
    factor = factor_of(band)
    solutions = [_solved(found, factor, order, len(others)) for order in range(max_order + 1)]
    return [_fit(solution, stiffness_orders, unknown_mass, misfit) for solution in solutions]


def _equation_error(
    span: _Span, windows: Windows, rows: Array, band: Array, order: int, others: int
) -> Array:
    """Covariance of the rows for a white force that the equation lacks, as strong as is most likely.

    Without it, rows that noise hardly touches may be believed beyond what the model can say; how much of what is
    left is noise of the channels, larger than was measured, and how much a force, the rows themselves tell.
    """
    white = band_of(windows, windows.kernel, span.motion.rate, np.ones_like)
    unit = float(np.mean(band[0]) / np.mean(white[0]))
    best, unlikely = 0.0, np.inf
    for share in _SHARES:
        factor = factor_of(band + share * unit * white)
        left = _solved(rows, factor, order, others).chi_square
        this = len(rows) * np.log(left) + 2 * float(np.sum(np.log(factor[0])))
        if this < unlikely:
            best, unlikely = share, this
    import os

    if os.environ.get("DBG"):
        print("   share", best)
    return np.asarray(best * unit * white)


def _solved(rows: Array, factor: Array, order: int, others: int) -> LeastSquares:
    kept = [*range(order + 1), *range(rows.shape[1] - 1 - others, rows.shape[1])]
    white = whiten(factor, rows[:, kept])
    return solve(white[:, :-1], white[:, -1])


def _fit(solution: LeastSquares, stiffness_orders: tuple[int, ...], unknown_mass: bool, misfit: bool) -> _Fit:
    order = len(solution.values) - len(stiffness_orders) - 2 - unknown_mass
    residual = solution.white.reshape(-1, 2).T.ravel()
    gain = solution.gain.reshape(len(solution.gain), -1, 2).swapaxes(1, 2).reshape(len(solution.gain), -1)
    if misfit:
        covariance = correlated_covariance(residual, gain, len(residual), len(gain))
    else:
        covariance = solution.covariance + misfit_covariance(residual, gain, len(residual), len(gain))
    clear = abs(float(solution.values[order])) / float(np.sqrt(covariance[order, order]))
    if misfit:
        covariance = widened(covariance, solution)
    stiffness = {
        j: float(chi) for j, chi in zip(stiffness_orders, solution.values[order + 1 :], strict=False)
    }
    offset = float(solution.values[order + 1 + len(stiffness_orders)])
    force_gain = float(solution.values[-1]) if unknown_mass else 1.0
    return _Fit(
        order,
        solution,
        clear,
        covariance,
        Polynomial(solution.values[: order + 1], stiffness, offset),
        force_gain,
    )


def _covariance(span: _Span, windows: Windows, mu_1: float, k_1: float) -> Array:
    """Covariance of the rows: what each channel's noise does to both sides of the equation of motion."""
    elastic = k_1 * windows.kernel - mu_1 * windows.slope
    kernels = {"consistent": windows.curvature + elastic, "elastic": elastic, "inertial": windows.kernel}
    w = span.angular_frequency
    return np.sum(
        [band_of(windows, kernels[name], span.motion.rate, _above(level, w)) for name, level in span.noise],
        axis=0,
    )


def _noise_velocity(span: _Span) -> float:
    if span.motion.noise_velocity is not None:
        return span.motion.noise_velocity
    w = np.array([span.angular_frequency])
    return float(w[0] * np.sqrt(span.noise[0][1](w)[0]))


def _above(spectrum: Callable[[Array], Array], w: float) -> Callable[[Array], Array]:
    """Hold a spectrum that rises towards zero frequency at its value at a third of the natural one."""
    return lambda at: spectrum(np.maximum(at, w / 3))


def _points(span: _Span) -> Array:
    """Samples of the span whose force and sign of velocity can be trusted, as indices into the motion."""
    v = span.cut(span.motion.velocity)
    turned = np.zeros(len(v), dtype=np.bool_)
    reversal = np.flatnonzero(v[1:] * v[:-1] <= 0)
    reach = min(_REACH, int(0.05 * 2 * np.pi * span.motion.rate / span.angular_frequency))
    for shift in range(1 - reach, reach + 1):
        turned[np.clip(reversal + shift, 0, len(v) - 1)] = True
    least = _SURE_SIGN * (span.motion.noise_velocity or 0.0)
    return span.first + np.flatnonzero(span.valid & ~turned & (np.abs(v) > least))


def _mse_percent(force: Array, fit: Array) -> float:
    return float(100 * np.mean((force - fit) ** 2) / np.var(force))


def _result(
    decay: FreeDecay, span: _Span, fits: list[_Fit], chosen: _Fit, reason: str, points: Array
) -> RestoringForceResult:
    motion = span.motion
    u, v = motion.displacement[points], motion.velocity[points]
    if len(points) < 8:
        raise NotIdentifiable("hardly a sample moves faster than its noise; release from a larger amplitude")

    def measured(fit: _Fit) -> Array:
        pull = 0.0 if span.force is None else fit.force_gain * span.force[points]
        return pull - motion.acceleration[points]

    force, polynomial = measured(chosen), chosen.polynomial
    force_fit = polynomial(u, v)
    spread = np.sqrt(np.diag(chosen.covariance))
    terms = {_damping_name(i): mu * np.abs(v) ** i * np.sign(v) for i, mu in enumerate(polynomial.damping)}
    terms |= {_power("u", j): chi * u**j for j, chi in polynomial.stiffness.items()}
    orders = list(polynomial.stiffness)
    per_mass = {
        j: Estimate(float(chi), float(spread[chosen.order + 1 + at]), stiffness_unit(j, False, decay.unit))
        for at, (j, chi) in enumerate(polynomial.stiffness.items())
    }
    by_order = {j: _with_mass(value, j, decay) for j, value in per_mass.items()}
    grid_u, grid_v, surface, visited = grid_of(polynomial, u, v)
    at_rest, at_zero = sections_of(polynomial, u, v, force)
    mass = None
    if span.force is not None and decay.mass is None:
        gain = chosen.force_gain
        mass = Estimate(1 / gain, float(spread[-1]) / gain**2, "force/acceleration")
    return RestoringForceResult(
        stiffness=by_order[orders[0]],
        stiffness_by_order=by_order,
        damping=tuple(
            Estimate(float(mu), float(spread[i]), damping_unit(i, decay.unit))
            for i, mu in enumerate(polynomial.damping)
        ),
        offset=Estimate(
            polynomial.offset, float(spread[chosen.order + 1 + len(orders)]), damping_unit(0, decay.unit)
        ),
        order=chosen.order,
        reason=reason,
        mse_percent=_mse_percent(force, force_fit),
        mse_percent_by_order=tuple(_mse_percent(measured(fit), fit.polynomial(u, v)) for fit in fits),
        significance_percent={
            name: float(100 * np.var(term) / np.var(force)) for name, term in terms.items()
        },
        source=motion.source,
        time=frozen((motion.start + points) / motion.rate),
        displacement=frozen(u),
        velocity=frozen(v),
        force=frozen(force),
        force_fit=frozen(force_fit),
        grid_displacement=grid_u,
        grid_velocity=grid_v,
        surface=surface,
        visited=visited,
        section_zero_velocity=at_rest,
        section_zero_displacement=at_zero,
        stiffness_per_mass=per_mass[orders[0]],
        mass=mass,
    )


def _damping_name(order: int) -> str:
    if order == 0:
        return "sgn(v)"
    if order % 2:
        return _power("v", order)
    return f"{_power('|v|', order)} sgn(v)"


def _power(symbol: str, order: int) -> str:
    return symbol if order == 1 else f"{symbol}^{order}"


def _with_mass(value: Estimate, order: int, decay: FreeDecay) -> Estimate:
    if decay.mass is None:
        return value
    spread = np.hypot(value.std * decay.mass, value.value * (decay.mass_std or 0.0))
    return Estimate(value.value * decay.mass, float(spread), stiffness_unit(order, True, decay.unit))
