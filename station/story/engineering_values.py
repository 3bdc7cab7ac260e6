"""The values that a test report quotes, in N, kg and s, Hz and 1, each with the parts of its error."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from identify.effects.effect import Effect
from identify.effects.force_effect import ForceEffect, LinearPart
from identify.effects.library import NAMED
from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.formatting import plain_name
from identify.units import power_in, unit_of

_NAMES = {
    LinearPart.STIFFNESS: "stiffness K",
    LinearPart.DRY_FRICTION: "friction force",
    LinearPart.DAMPING: "viscous damping μ₁",
}


@dataclass(frozen=True)
class EngineeringValue:
    """A value under its name; `per_mass` is the same per unit mass (inertia), None where it has no mass in it."""

    name: str
    value: Estimate
    per_mass: Estimate | None = None


@dataclass(frozen=True)
class Weighing:
    """The mass in kg (kg m^2 for a displacement in rad), where it is known: forces and strengths are in N, kg and s then."""

    mass: float | None = None
    mass_std: float | None = None
    unit: str = "m"

    @property
    def force_scale(self) -> tuple[float, str]:
        """The factor from a force per unit mass to the force that is shown, and its unit."""
        one = self.strength(Estimate(1.0, 0.0, f"{self.unit}/s^2"))
        return one.value, one.unit

    @property
    def words(self) -> str:
        """What forces and strengths are where no mass is known; "" where it is."""
        return "" if self.mass is not None else self.worded("the mass is not given: all is per unit mass")

    def worded(self, words: str = "force per unit mass") -> str:
        """Write words of forces per unit mass as what is shown: forces with a mass, torques and inertias of angles."""
        shown = words if self.mass is None else re.sub(r",? per unit mass", "", words)
        return shown.replace("force", "torque").replace("mass", "inertia") if self.unit == "rad" else shown

    def strength(self, found: Any) -> Any:
        """Return a strength (or None) with the mass in it, where both are known and the strength is no pure number.

        The error of the mass joins that of the strength.
        """
        if self.mass is None or found is None or found.value is None or found.unit in ("", "1"):
            return found
        std = math.nan if found.std is None else found.std
        error = math.hypot(std * self.mass, found.value * (self.mass_std or 0.0))
        return Estimate(found.value * self.mass, error, _times_mass(found.unit, self.unit))

    def weighed(self, effect: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
        """Return the parameters of an effect with the mass in its strength, the first of them, if it is a force.

        What changes a parameter of another effect is relative to that, and has no mass in it.
        """
        other = any(e.name == effect and not _has_mass(e) for e in NAMED)
        first = () if other else list(parameters.items())[:1]
        return dict(parameters) | {name: self.strength(found) for name, found in first}

    def terms(self, effects: Iterable[Effect], *, in_numbers: bool = False) -> list[str]:
        """Write the terms of an equation of motion, the inertia first: forces where the mass is known, as m or a number."""
        forces = [effect for effect in effects if isinstance(effect, ForceEffect)]
        if self.mass is None:
            return ["u''", *(effect.equation for effect in forces)]
        m = f"{self.mass:g}" if in_numbers else "J" if self.unit == "rad" else "m"
        pure = [_has_mass(effect) and effect.strength.unit in ("", "1") for effect in forces]
        parts = (effect.equation.partition(",  ") for effect in forces)
        terms = (
            f"{m} ({force}){comma}{rest}" if share else f"{force}{comma}{rest}"
            for (force, comma, rest), share in zip(parts, pure, strict=True)
        )
        return [f"{m} u''", *terms]


def _has_mass(effect: Effect) -> bool:
    return isinstance(effect, ForceEffect) and not effect.relative


def _times_mass(unit: str, length: str) -> str:
    """Return the unit of a mass, of an inertia where the length is "rad", times a unit: "N/m" for "1/s^2"."""
    kg, force = ("kg m^2", "N m") if length == "rad" else ("kg", "N")
    powers = {"s": 2 + power_in(unit, {"s": 1}), length: power_in(unit, {length: 1}) - 1}
    other = set(re.findall("[A-Za-z]+", unit)) - powers.keys() or length not in ("m", "rad")
    if other or (length == "m" and powers["s"] > 1):
        return f"{kg} {unit}".replace(" 1/", "/")
    return unit_of({force: 1, **powers})


UNKNOWN = Weighing()


@dataclass(frozen=True)
class Budget:
    """Standard errors of one value, in its unit: of readings and clock, calibration, mass; None where not stated."""

    readings: float
    calibration: float | None
    mass: float | None

    @property
    def total(self) -> float | None:
        """The combined standard uncertainty (GUM); None where a part is not known."""
        if self.calibration is None or self.mass is None:
            return None
        return math.hypot(self.readings, self.calibration, self.mass)


def budget(
    one: EngineeringValue, calibration: float | None, mass_share: float | None, length: str = "m"
) -> Budget:
    """Split the error of a value into its parts.

    `calibration` is the relative uncertainty of the sensors' scale, `mass_share` that of the mass, None where not stated.
    The scale of the sensors enters a value by the power of `length` ("m" or "rad") in its unit per unit mass: not at all
    in a stiffness or a frequency, once in a friction force.
    """
    value, bare = one.value, one.per_mass
    readings: float = value.std
    mass: float | None = 0.0
    if bare is not None:
        readings = bare.std * abs(value.value / bare.value) if bare.value else bare.std
        mass = None if mass_share is None else abs(value.value) * mass_share
    power = abs(power_in((bare or value).unit, {length: 1}))
    scale = 0.0 if power == 0 else None if calibration is None else power * calibration * abs(value.value)
    return Budget(readings, scale, mass)


def engineering_values(fit: Fit, weighing: Weighing) -> tuple[EngineeringValue, ...]:
    """List the quoted values of a fit: strengths in N, kg and s where the mass is known, frequency and damping.

    The frequency is that of the undamped spring, the damping ratio and the logarithmic decrement those of the viscous
    part: mu_1/(2 w) and 2 pi zeta/sqrt(1 - zeta^2), with w^2 the stiffness per unit mass.
    """
    found = []
    for term in fit.model.forces:
        part, bare = term.force.linear_part, fit.of(term, 0)
        inner = part is None and term.effect in NAMED
        for name, value in weighing.weighed(term.effect.name, bare).items():
            called = (
                f"{plain_name(term.effect.name)}, {name}" if part is None else weighing.worded(_NAMES[part])
            )
            if inner or name == term.effect.strength.name:
                found.append(EngineeringValue(called, value, None if value is bare[name] else bare[name]))
    return (*found, *_of_the_oscillation(fit))


def _of_the_oscillation(fit: Fit) -> tuple[EngineeringValue, ...]:
    k, mu_1 = _linear(fit, LinearPart.STIFFNESS), _linear(fit, LinearPart.DAMPING)
    if k is None or not k.value > 0.0:
        return ()
    omega = math.sqrt(k.value)
    omega_std = k.std / (2.0 * omega)
    hertz = 1.0 / (2.0 * math.pi)
    frequency = EngineeringValue("natural frequency", Estimate(omega * hertz, omega_std * hertz, "Hz"))
    if mu_1 is None:
        return (frequency,)
    zeta = mu_1.value / (2.0 * omega)
    zeta_std = math.hypot(mu_1.std / (2.0 * omega), zeta * omega_std / omega)
    ratio = EngineeringValue("damping ratio (viscous part)", Estimate(zeta, zeta_std, "1"))
    if not abs(zeta) < 1.0:  # another spring carries the mass: the linear one alone would not oscillate
        return (frequency, ratio)
    root = math.sqrt(1.0 - zeta * zeta)
    decrement = Estimate(2.0 * math.pi * zeta / root, 2.0 * math.pi * zeta_std / root**3, "1")
    return (frequency, ratio, EngineeringValue("logarithmic decrement (viscous part)", decrement))


def _linear(fit: Fit, part: LinearPart) -> Estimate | None:
    name = fit.model.linear_strength(part)
    return None if name is None else fit.values[str(name)]
