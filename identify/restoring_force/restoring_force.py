"""The restoring force surface, eqs. (13)-(19)."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, frozen
from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.free_decay import FreeDecay
from identify.identified import Identified, damping_unit, dampings, estimate, stiffnesses, with_mass
from identify.preprocessing.aligned_decay import AlignedDecay, aligned
from identify.preprocessing.motion import reconstruct
from identify.preprocessing.sampling import block_averaged
from identify.restoring_force.force_regression import ForceFit, Polynomial, fit_orders
from identify.restoring_force.force_window import ForceWindow, points_of, window_of
from identify.signal.order_selection import choose_order
from identify.signal.weak_form import place_windows
from identify.summary import Summary

_ROUNDS = 6  # fits, each about the rest position that the last one found
_SETTLED = 1e-6  # of the motion, by which that may be off


@dataclass(frozen=True, eq=False)
class Section:
    """A cut of the surface, shape (n,) each.

    `position` (m or m/s) in ascending order, the measured force per unit mass, and the fit.
    """

    position: Array
    force: Array
    fit: Array


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RestoringForceResult(Identified):
    """The result of the restoring force surface.

    `stiffness_by_order` holds every displacement order that was kept, `damping` begins with sgn v; `offset` is the
    constant force per unit mass at the rest position. `mse_percent` is eq. (18), `significance_percent` eq. (19) by term
    name. Points used, shape (n,): `time` (s, on the record's clock), `displacement` (from the rest position), `velocity`,
    `force` (per unit mass, eq. 14) and the surface there, `force_fit`. Sections at v = 0 and u = 0. `mass` is
    what a recorded force says of the mass, in the force's unit over m/s^2, when none was given; None otherwise.
    """

    offset: Estimate
    mse_percent: float
    significance_percent: dict[str, float]
    source: str
    time: Array
    displacement: Array
    velocity: Array
    force: Array
    force_fit: Array
    section_zero_velocity: Section
    section_zero_displacement: Section
    mass: Estimate | None = None

    def brief(self) -> Summary:
        """Return the coefficients with their errors, and why these orders were chosen."""
        return Summary("Restoring force surface", (f"{self.reason}.",), ("coefficient", "value"), self.rows)


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
    the lag's standard error adds nothing here. Where viscous damping was tried and is not there, the error of dry
    friction is that beside it. Raises NotIdentifiable when there is too little to identify.
    """
    stiffness_orders = tuple(sorted(stiffness_orders))
    decay, begins = block_averaged(aligned(decay))
    motion = reconstruct(decay)
    window = window_of(decay, motion)
    windows = place_windows(window.valid, motion.rate, window.angular_frequency)
    if 2 * len(windows.first) < max_order + len(stiffness_orders) + 4:
        raise NotIdentifiable(
            "too few cycles for windows of two; release from a larger amplitude or record longer"
            if window.valid.all()
            else "lost readings and outliers leave too few whole stretches of two cycles; release from a larger "
            "amplitude, or record again"
        )
    # Powers of a displacement that is counted from elsewhere than the rest position are not those of the law.
    rest = window.middle
    for _ in range(_ROUNDS):
        window = window.about(rest)
        fits = fit_orders(window, windows, max_order, stiffness_orders, decay)
        moved = window.cut(window.motion.displacement)
        rest = fits[max_order].polynomial.rest(moved)
        if abs(rest) < _SETTLED * float(np.std(moved)):
            break
    tried = fits[least_order:]
    clear = [fit.clear for fit in tried]
    misfits = [fit.solution.chi_square for fit in tried]
    orders = range(least_order, max_order + 1)
    order, reason = choose_order(orders, misfits, clear, "damping")
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
        raise NotIdentifiable("too few velocities exceed their noise; release from a larger amplitude")

    def measured(fit: ForceFit) -> Array:
        pull = np.zeros(len(points)) if window.force is None else fit.force_gain * window.force[points]
        return np.asarray(pull - motion.acceleration[points])

    force, polynomial = measured(chosen), chosen.polynomial
    force_fit = polynomial(u, v)
    terms = {_damping_name(i): mu * np.abs(v) ** i * np.sign(v) for i, mu in enumerate(polynomial.damping)}
    terms |= {_power("u", j): chi * u**j for j, chi in polynomial.stiffness.items()}
    std = chosen.std
    damping_std, stiffness_std, offset_std = np.split(
        std, [chosen.order + 1, chosen.order + 1 + len(polynomial.stiffness)]
    )
    per_mass = stiffnesses(
        decay, {j: (chi, s) for (j, chi), s in zip(polynomial.stiffness.items(), stiffness_std, strict=True)}
    )
    at_rest, at_zero = _sections_of(polynomial, u, v, force)
    return RestoringForceResult(
        stiffness_by_order=with_mass(decay, per_mass),
        damping=dampings(decay, zip(polynomial.damping, damping_std, strict=True)),
        offset=estimate(decay, polynomial.offset, offset_std[0], damping_unit(0, decay.unit)),
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
        section_zero_velocity=at_rest,
        section_zero_displacement=at_zero,
        stiffness_per_mass=next(iter(per_mass.values())),
        mass=None if window.force is None or decay.mass is not None else _mass(chosen),
    )


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


def _sections_of(
    polynomial: Polynomial, displacement: Array, velocity: Array, force: Array
) -> tuple[Section, Section]:
    """Return the sections at v = 0 and at u = 0 of the measured points (n,).

    Points within a tenth of the largest velocity (displacement) of the cut are carried onto it along the fitted surface;
    the sign of a velocity of zero counts as none, so the first section is elastic.
    """
    residual = force - polynomial(displacement, velocity)
    elastic = polynomial.elastic(displacement)
    dissipative = polynomial.dissipative(velocity) + polynomial.offset
    return _section(displacement, velocity, elastic, residual), _section(
        velocity, displacement, dissipative, residual
    )


def _section(along: Array, across: Array, fit: Array, residual: Array) -> Section:
    near = np.flatnonzero(np.abs(across) < 0.1 * np.max(np.abs(across)))
    near = near[np.argsort(along[near])]
    return Section(frozen(along[near]), frozen((fit + residual)[near]), frozen(fit[near]))
