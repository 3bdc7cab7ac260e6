"""The identity of a parameter: whose it is, in which release, and what for."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Self

Role = Literal["parameter", "state", "nuisance"]
"""A parameter of an effect, an internal state of one at the start of a release, or what a release needs besides."""


@dataclass(frozen=True)
class ParameterId:
    """A parameter of `effect` ("" for what belongs to none).

    `release` counts from 0; it is None where all releases share the parameter, and where there is only one.
    """

    effect: str
    parameter: str
    release: int | None = None
    role: Role = "parameter"

    def __str__(self) -> str:
        """Return the name in documents and messages: "linear_stiffness.k", "lag[1]", "hysteresis.state0"."""
        return f"{self.effect}.{self.in_effect}" if self.effect else self.in_effect

    @property
    def in_effect(self) -> str:
        """The name without the effect's."""
        return self.parameter if self.release is None else f"{self.parameter}[{self.release}]"

    def of_release(self, release: int, count: int) -> Self:
        """Return the same of one of `count` releases, which has a number only among several."""
        return type(self)(self.effect, self.parameter, release if count > 1 else None, self.role)


def values_in_release(values: Mapping[str, float], release: int) -> dict[str, float]:
    """Return values by name as one of several releases has them, under their names in that release alone."""
    own, shared = f"[{release}]", {name: value for name, value in values.items() if not name.endswith("]")}
    return shared | {name.removesuffix(own): value for name, value in values.items() if name.endswith(own)}


def nuisance(name: str, release: int = 0, count: int = 1) -> ParameterId:
    """Return the identity of what a release needs besides the effects: its start, lag, gain, offsets."""
    return ParameterId("", name, None, "nuisance").of_release(release, count)
