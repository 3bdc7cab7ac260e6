"""The restoring force surface, eqs. (13)-(19)."""

from dataclasses import dataclass

from identify.arrays import Array
from identify.estimate import Estimate


@dataclass(frozen=True, eq=False)
class Section:
    """A cut of the surface: `position` (m or m/s), measured force per unit mass with its standard error, the fit, shape (n,)."""

    position: Array
    force: Array
    std: Array
    fit: Array


@dataclass(frozen=True, eq=False)
class RestoringForceResult:
    """What the restoring force surface says.

    `stiffness` is K (N/m with a mass, 1/s^2 without); `damping` holds mu_i per unit mass by order
    i = 0..`order` (0 is sgn v); `stiffness_by_order` every displacement order that was kept; `offset` the
    constant force per unit mass. `mse_percent_by_order` is eq. (18) for damping orders 0..max (fig. 3b),
    `significance_percent` eq. (19) by term name. Points used, shape (n,): `displacement`, `velocity`,
    `force` (per unit mass, eq. 14) and `force_fit`. The surface on a grid: `grid_displacement` (p,), `grid_velocity` (q,),
    `surface` (q, p) fitted, `visited` (q, p) counts of points. Sections at v = 0 and u = 0.
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
