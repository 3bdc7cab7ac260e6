"""A family of effects: one law with a free exponent, of which named effects are members."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from identify.effects.effect import Scales
from identify.effects.force_effect import ForceEffect


@dataclass(frozen=True, eq=False, kw_only=True)
class Family:
    """A law with a free exponent, for shapes between the names: "behaves like quadratic_damping, p = 1.9 +- 0.1".

    `effect` is fitted as any other force; `exponent` names its parameter. `members` gives the exponent at which the law
    is an effect of the library, by that effect's name. `held(scales)` are the inner parameters to hold in a fit, chosen
    so that strength and exponent are hardly correlated.
    """

    effect: ForceEffect
    exponent: str
    members: Mapping[str, float]
    held: Callable[[Scales], dict[str, float]] = field(default=lambda scales: {})

    def __post_init__(self) -> None:
        at = self.effect.parameters[self.effect.index(self.exponent)]
        outside = [name for name, value in self.members.items() if not at.low <= value <= at.high]
        if outside or not self.members:
            raise ValueError(
                f"family {self.effect.name}: no exponent for {', '.join(outside) or 'any member'}"
            )

    def nearest(self, exponent: float) -> str:
        """Return the member whose exponent is nearest to a given one."""
        return min(self.members, key=lambda name: abs(self.members[name] - exponent))
