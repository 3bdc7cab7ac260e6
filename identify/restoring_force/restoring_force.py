"""The restoring force surface, eqs. (13)-(19)."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from identify.arrays import Array, frozen
from identify.clock_error import with_clock
from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.formatting import identified_rows
from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import AlignedDecay, aligned
from identify.preprocessing.decimation import block_averaged
from identify.preprocessing.motion import reconstruct
from identify.restoring_force.force_regression import ForceFit, fit_orders
from identify.restoring_force.force_window import ForceWindow, points_of, window_of
from identify.restoring_force.surface import Section, grid_of, sections_of
from identify.signal.order_selection import choose_order
from identify.signal.weak_form import place_windows
from identify.summary import Summarised, Summary
from identify.units import damping_unit, stiffness_unit, with_mass

_FALL = 0.995  # of the lower order's misfit: there are many rows, and most hold no damping


@dataclass(frozen=True, eq=False, repr=False)
class RestoringForceResult(Summarised):
    """The result of the restoring force surface.

    `stiffness` is K (N/m with a mass, 1/s^2 without); `damping` holds mu_i per unit mass by order
    i = 0..`order` (0 is sgn v); `stiffness_by_order` every displacement order that was kept; `offset` the
    constant force per unit mass. `mse_percent_by_order` is eq. (18) for damping orders 0..max (fig. 3b),
    `significance_percent` eq. (19) by term name. Points used, shape (n,): `time` (s, on the record's
    clock), `displacement`, `velocity`, `force` (per unit mass, eq. 14) and `force_fit`. The surface on a grid:
    `grid_displacement` (p,), `grid_velocity` (q,), `surface` (q, p) fitted. Sections at v = 0 and
    u = 0. `stiffness_per_mass` (1/s^2) leaves the mass's uncertainty out. `mass` is what a recorded force says of the mass,
    in the force's unit over m/s^2, when none was given; None otherwise.
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
    section_zero_velocity: Section
    section_zero_displacement: Section
    stiffness_per_mass: Estimate
    mass: Estimate | None = None

    def brief(self) -> Summary:
        """Return the coefficients with their errors, and why these orders were chosen."""
        rows = identified_rows(self.stiffness_by_order, self.damping)
        return Summary("Restoring force surface", (f"{self.reason}.",), ("coefficient", "value"), rows)


def identify_restoring_force(
    decay: FreeDecay | AlignedDecay,
    max_order: int = 3,
    stiffness_orders: tuple[int, ...] = (1,),
    least_order: int = 0,
) -> RestoringForceResult:
    """Identify the restoring force of a decay; one that has not been located is located and aligned first.

    `max_order` is the highest order of damping tried, `least_order` the lowest, `stiffness_orders` are the displacement
    orders of eq. (15).
    With a recorded `force` the equation is driven (eq. 14): as force per unit mass where the mass is known, else
    with one more unknown, 1/m. Since the motion's parts agree with each other whatever small lag is left,
    the lag's standard error adds nothing here. Raises NotIdentifiable when there is too little to identify.
    """
    decay, begins = block_averaged(aligned(decay))
    motion = reconstruct(decay)
    window = window_of(decay, motion)
    windows = place_windows(window.valid, motion.rate, window.angular_frequency)
    if 2 * len(windows.first) < max_order + len(stiffness_orders) + 4:
        raise NotIdentifiable(
            "too few cycles for windows of two; release from a larger amplitude or record longer"
            if window.valid.all()
            else "gaps leave too few whole stretches of two cycles; record again without losses"
        )
    fits = fit_orders(window, windows, max_order, stiffness_orders, decay)
    tried = fits[least_order:]
    clear = [fit.clear for fit in tried]
    misfits = [fit.solution.chi_square for fit in tried]
    orders = range(least_order, max_order + 1)
    order, reason = choose_order(orders, misfits, clear, [_FALL] * len(tried), "damping")
    return _result(decay, begins, window, fits, fits[order], reason)


def _mse_percent(force: Array, fit: Array) -> float:
    return float(100 * np.mean((force - fit) ** 2) / np.var(force))


def _result(
    decay: FreeDecay,
    begins: float,
    window: ForceWindow,
    fits: list[ForceFit],
    chosen: ForceFit,
    reason: str,
) -> RestoringForceResult:
    motion, points = window.motion, points_of(window)
    u, v = motion.displacement[points], motion.velocity[points]
    if len(points) < 8:
        raise NotIdentifiable("hardly a sample moves faster than its noise; release from a larger amplitude")

    def measured(fit: ForceFit) -> Array:
        pull = np.zeros(len(points)) if window.force is None else fit.force_gain * window.force[points]
        return np.asarray(pull - motion.acceleration[points])

    force, polynomial = measured(chosen), chosen.polynomial
    force_fit = polynomial(u, v)
    terms = {_damping_name(i): mu * np.abs(v) ** i * np.sign(v) for i, mu in enumerate(polynomial.damping)}
    terms |= {_power("u", j): chi * u**j for j, chi in polynomial.stiffness.items()}
    timed = partial(with_clock, rate=decay.rate, rate_std=decay.rate_std)
    damping, stiffness, offset = _estimates(chosen, decay.unit)
    per_mass = {j: timed(value) for j, value in stiffness.items()}
    by_order = {
        j: with_mass(value, j, decay.mass, decay.mass_std, decay.unit) for j, value in per_mass.items()
    }
    first = next(iter(per_mass))
    grid_u, grid_v, surface = grid_of(polynomial, u, v)
    at_rest, at_zero = sections_of(polynomial, u, v, force)
    return RestoringForceResult(
        stiffness=by_order[first],
        stiffness_by_order=by_order,
        damping=tuple(timed(value) for value in damping),
        offset=timed(offset),
        order=chosen.order,
        reason=reason,
        mse_percent=_mse_percent(force, force_fit),
        mse_percent_by_order=tuple(_mse_percent(measured(fit), fit.polynomial(u, v)) for fit in fits),
        significance_percent={
            name: float(100 * np.var(term) / np.var(force)) for name, term in terms.items()
        },
        source=motion.source,
        time=frozen(begins + (motion.start + points) / motion.rate),
        displacement=frozen(u),
        velocity=frozen(v),
        force=frozen(force),
        force_fit=frozen(force_fit),
        grid_displacement=grid_u,
        grid_velocity=grid_v,
        surface=surface,
        section_zero_velocity=at_rest,
        section_zero_displacement=at_zero,
        stiffness_per_mass=per_mass[first],
        mass=None if window.force is None or decay.mass is not None else _mass(chosen),
    )


def _estimates(fit: ForceFit, unit: str) -> tuple[tuple[Estimate, ...], dict[int, Estimate], Estimate]:
    """Return damping by order, stiffness per unit mass by its order, and the offset, with their standard errors."""
    found, std = fit.polynomial, iter(float(x) for x in fit.std)
    damping = tuple(
        Estimate(float(mu), next(std), damping_unit(i, unit)) for i, mu in enumerate(found.damping)
    )
    stiffness = {
        j: Estimate(chi, next(std), stiffness_unit(j, False, unit)) for j, chi in found.stiffness.items()
    }
    return damping, stiffness, Estimate(found.offset, next(std), damping_unit(0, unit))


def _mass(fit: ForceFit) -> Estimate:
    return Estimate(1 / fit.force_gain, float(fit.std[-1]) / fit.force_gain**2, "force/acceleration")


def _damping_name(order: int) -> str:
    if order == 0:
        return "sgn(v)"
    if order % 2:
        return _power("v", order)
    return f"{_power('|v|', order)} sgn(v)"


def _power(symbol: str, order: int) -> str:
    return symbol if order == 1 else f"{symbol}^{order}"
