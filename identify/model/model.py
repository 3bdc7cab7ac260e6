"""A model: a sum of named effects."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from identify.effects.effect import Effect, Parameter
from identify.effects.force_effect import ForceEffect, LinearPart
from identify.effects.library import BASE, DAMPING_BY_ORDER, STIFFNESS_BY_ORDER
from identify.effects.sensor_fault import SensorFault
from identify.model.parameter_id import ParameterId


@dataclass(frozen=True, eq=False)
class Term:
    """An effect as it stands in a model; `held` are inner values that are not fitted, and the channel at fault."""

    effect: Effect
    held: Mapping[str, float | str] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def channel(self) -> str:
        """The channel in which a sensor's fault sits, or ""."""
        return str(self.held.get("channel", ""))

    @property
    def free(self) -> tuple[Parameter, ...]:
        """The parameters that are fitted."""
        return tuple(p for p in self.effect.parameters if p.name not in self.held)

    @property
    def held_values(self) -> dict[str, float]:
        """The inner parameters that are held, by their own names."""
        return {name: float(value) for name, value in self.held.items() if name != "channel"}

    @property
    def is_force(self) -> bool:
        """Whether the effect is a force, not a fault of a sensor."""
        return isinstance(self.effect, ForceEffect)

    @property
    def force(self) -> ForceEffect:
        """The effect as a force; TypeError for a fault of a sensor."""
        if not isinstance(self.effect, ForceEffect):
            raise TypeError(f"{self.effect.name} is a fault of a sensor: it has no force")
        return self.effect

    @property
    def fault(self) -> SensorFault:
        """The effect as a fault of a sensor; TypeError for a force."""
        if not isinstance(self.effect, SensorFault):
            raise TypeError(f"{self.effect.name} is a force, not a fault of a sensor")
        return self.effect

    @property
    def strength(self) -> ParameterId:
        """The identity of the first parameter."""
        return self.parameter(self.effect.strength.name)

    def parameter(self, name: str, release: int | None = None) -> ParameterId:
        """Return the identity of a parameter; a fault's, where there are several releases, of one of them."""
        return ParameterId(self.effect.name, name, release)

    def in_release(self, parameter: Parameter, release: int, count: int) -> ParameterId:
        """Return the identity of a force's parameter in one of `count` releases, which share all but a few."""
        id = self.parameter(parameter.name)
        return id.of_release(release, count) if parameter.of_release else id

    def state(self, place: int, release: int | None = None) -> ParameterId:
        """Return the identity of an internal state at the start of a release."""
        return ParameterId(self.effect.name, f"state{place}", release, "state")

    def by_name(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return values of parameters, given by their own names, by the names of unknowns."""
        return {str(self.parameter(name)): value for name, value in values.items()}


@dataclass(frozen=True, eq=False)
class Model:
    """A sum of effects, in the order in which they were added."""

    terms: tuple[Term, ...] = tuple(Term(effect) for effect in BASE)

    def __contains__(self, name: object) -> bool:
        return any(term.effect.name == name for term in self.terms)

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names."""
        return tuple(term.effect.name for term in self.terms)

    @property
    def forces(self) -> tuple[Term, ...]:
        """The forces."""
        return tuple(term for term in self.terms if term.is_force)

    @property
    def faults(self) -> tuple[Term, ...]:
        """The faults of sensors."""
        return tuple(term for term in self.terms if not term.is_force)

    @property
    def equation(self) -> str:
        """The equation of motion per unit mass, sensors' faults left out."""
        return "u'' + " + " + ".join(term.effect.equation for term in self.forces) + " = 0"

    def linear_strength(self, part: LinearPart) -> ParameterId | None:
        """Return the strength of the model's linear stiffness, damping or dry friction; None where it has none."""
        return next((term.strength for term in self.forces if term.force.linear_part == part), None)

    def plus(self, term: Term) -> "Model":
        """Return the model with one more effect; ValueError when it is there already."""
        if term.effect.name in self:
            raise ValueError(f"{term.effect.name} is in the model already")
        return Model((*self.terms, term))

    def minus(self, name: str) -> "Model":
        """Return the model without an effect; KeyError when it is not there."""
        if name not in self:
            raise KeyError(f"{name} is not in the model: {', '.join(self.names)}")
        return Model(tuple(term for term in self.terms if term.effect.name != name))


def base_model() -> Model:
    """Return stiffness, Coulomb friction and viscous damping."""
    return Model()


def model_of_orders(damping: int, stiffness: Iterable[int] = (1,)) -> Model:
    """Return springs of the orders `stiffness` with damping of every order up to `damping`, 0 being dry friction.

    Orders that no effect of the library has are left out.
    """
    springs = [STIFFNESS_BY_ORDER[order] for order in sorted(stiffness) if order in STIFFNESS_BY_ORDER]
    return Model(tuple(Term(effect) for effect in (*springs, *DAMPING_BY_ORDER[: damping + 1])))
