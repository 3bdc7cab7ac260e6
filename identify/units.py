"""Units of the identified parameters, spelled from the unit of the displacement."""

from math import hypot

from identify.estimate import Estimate


def damping_unit(order: int, unit: str = "m") -> str:
    """Return the unit of mu_i, a force per unit mass over the i-th power of a velocity.

    `unit` is that of the displacement ("m" or "rad"): order 0 gives m/s^2, 1 gives 1/s, 2 gives 1/m,
    3 gives s/m^2.
    """
    if order == 0:
        return f"{unit}/s^2"
    if order == 1:
        return "1/s"
    time = "" if order == 2 else "s" if order == 3 else f"s^{order - 2}"
    length = unit if order == 2 else f"{unit}^{order - 1}"
    return f"{time or '1'}/{length}"


def stiffness_unit(order: int, mass_known: bool, unit: str = "m") -> str:
    """Return the unit of a stiffness of odd or even `order`: N/m^i with a mass, 1/s^2/m^(i-1) without.

    For an angle a known inertia makes the numerator a moment, N m.
    """
    power = unit if order == 1 else f"{unit}^{order}"
    if mass_known:
        return f"{'N m' if unit == 'rad' else 'N'}/{power}"
    if order == 1:
        return "1/s^2"
    return f"1/(s^2 {unit if order == 2 else f'{unit}^{order - 1}'})"


def with_mass(
    value: Estimate, order: int, mass: float | None, mass_std: float | None, unit: str = "m"
) -> Estimate:
    """Return a stiffness of `order` per unit mass times the mass, the mass's uncertainty with it.

    Unchanged but for its unit when the mass is None.
    """
    spelled = stiffness_unit(order, mass is not None, unit)
    if mass is None:
        return Estimate(value.value, value.std, spelled)
    return Estimate(value.value * mass, hypot(value.std * mass, value.value * (mass_std or 0.0)), spelled)
