"""A model: a sum of named effects."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from identify.effects.effect import Effect, Parameter
from identify.effects.library import BASE


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
    def equation(self) -> str:
        """The equation of motion per unit mass, sensors' faults left out."""
        return (
            "u'' + "
            + " + ".join(t.effect.equation for t in self.terms if t.effect.kind == "physics")
            + " = 0"
        )

    def plus(self, term: Term) -> "Model":
        """Return the model with one more effect; ValueError when it is there already."""
        if any(term.effect.name == t.effect.name and term.channel == t.channel for t in self.terms):
            raise ValueError(f"{term.effect.name} is in the model already")
        return Model((*self.terms, term))

    def minus(self, name: str) -> "Model":
        """Return the model without an effect; KeyError when it is not there."""
        if name not in self:
            raise KeyError(f"{name} is not in the model: {', '.join(self.names)}")
        return Model(tuple(term for term in self.terms if term.effect.name != name))


def base_model(*, dry_friction: bool = True) -> Model:
    """Return stiffness and viscous damping, with or without Coulomb friction."""
    return Model(tuple(Term(e) for e in BASE if dry_friction or e.name != "coulomb_friction"))
