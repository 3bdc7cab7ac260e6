"""What both identifications of the paper find: stiffness and damping by order, with their errors and units."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import hypot

from identify.clock_error import with_clock
from identify.estimate import Estimate
from identify.formatting import damping_name, quantity, stiffness_name
from identify.free_decay import FreeDecay
from identify.summary import Summarised
from identify.units import unit_of


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Identified(Summarised):
    """Stiffness and damping of a decay.

    `stiffness_by_order` holds K (N/m with a mass, 1/s^2 without) by the order of the displacement, the lowest first,
    `damping` mu_i per unit mass by order i = 0..`order`, `stiffness_per_mass` (1/s^2) the first stiffness without the mass
    and its uncertainty. `mse_percent_by_order` is the misfit for damping orders 0..max (fig. 3), `reason` says why the order
    was chosen.
    """

    stiffness_by_order: dict[int, Estimate]
    stiffness_per_mass: Estimate
    damping: tuple[Estimate, ...]
    order: int
    reason: str
    mse_percent_by_order: tuple[float, ...]

    @property
    def stiffness(self) -> Estimate:
        """The stiffness of the lowest order."""
        return next(iter(self.stiffness_by_order.values()))

    @property
    def parameters(self) -> dict[str, Estimate]:
        """Each stiffness and damping coefficient, by its name with its order."""
        found = {stiffness_name(order): value for order, value in self.stiffness_by_order.items()}
        return found | {damping_name(order): value for order, value in enumerate(self.damping)}

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Name and value of each."""
        return [(name, quantity(value)) for name, value in self.parameters.items()]


def estimate(decay: FreeDecay, value: float, std: float, unit: str) -> Estimate:
    """Make an estimate of a decay, whose error includes that of its clock."""
    return with_clock(Estimate(float(value), float(std), unit), decay.rate, decay.rate_std)


def dampings(decay: FreeDecay, found: Iterable[tuple[float, float]]) -> tuple[Estimate, ...]:
    """Return mu_0, mu_1, ... of their values and standard errors."""
    return tuple(
        estimate(decay, value, std, damping_unit(order, decay.unit))
        for order, (value, std) in enumerate(found)
    )


def stiffnesses(decay: FreeDecay, found: dict[int, tuple[float, float]]) -> dict[int, Estimate]:
    """Return stiffnesses per unit mass, by order, of their values and standard errors."""
    return {
        order: estimate(decay, value, std, unit_of({"s": -2, decay.unit: 1 - order}))
        for order, (value, std) in found.items()
    }


def with_mass(decay: FreeDecay, per_mass: dict[int, Estimate]) -> dict[int, Estimate]:
    """Return stiffnesses times the mass, the mass's uncertainty with it; unchanged where the mass is unknown."""
    mass, mass_std = decay.mass, decay.mass_std or 0.0
    if mass is None:
        return per_mass
    return {
        order: Estimate(
            k.value * mass,
            hypot(k.std * mass, k.value * mass_std),
            unit_of({"N m" if decay.unit == "rad" else "N": 1, decay.unit: -order}),
        )
        for order, k in per_mass.items()
    }


def damping_unit(order: int, unit: str) -> str:
    """Return the unit of mu_i, a force per unit mass over the i-th power of a velocity: m/s^2, 1/s, 1/m, s/m^2, ...

    `unit` is that of the displacement ("m" or "rad").
    """
    return unit_of({"s": order - 2, unit: 1 - order})
