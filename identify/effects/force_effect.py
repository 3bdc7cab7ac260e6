"""A force per unit mass: its definition, and its values along a given motion."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from enum import IntEnum
from math import inf, isfinite
from types import FunctionType
from typing import Any, cast

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS, RATES, STATES, address_of, effect_function
from identify.effects.compiled_path import states_along, values_along
from identify.effects.effect import Effect, Scales, Starts

Numbers = tuple[float, ...]
"""The parameters of an effect as its compiled functions take them."""

_STEPS = 4
"""Steps between two samples of a measured motion."""

_MOST_TURNS = 400
_TURNS_TO_NEWTON = 4
_SETTLED = 1e-6
"""Change of the states in one turn, in units of their size, below which they are periodic."""


class LinearPart(IntEnum):
    """The forces that the simulator has built in: in proportion to displacement, to velocity, to its sign."""

    STIFFNESS = 0
    DAMPING = 1
    DRY_FRICTION = 2


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceEffect(Effect):
    """A force per unit mass on the left of u'' + ... = 0, proportional to its first parameter, the strength.

    `force`, `friction` and `rates` are functions of (t, u, v, z, p), which are compiled: `friction` is a level that
    acts against the velocity, `rates` drives `states` internal states `z`, two at most; `t` counts from the release, and
    `p` holds the parameters in their order. `shared_parameters` belong to other effects and follow the effect's own in `p`:
    by "effect.parameter", each with its rough value at an angular frequency (rad/s). `equilibrium_state(u, p)` gives the
    internal states of a mass that has been held at `u` for long; with `fading_memory`, how it came there does not matter
    and these are its states at the release, otherwise they are unknowns of the fit. `starts(scales)` lists starting values
    of the inner parameters, `reach(scales)` close ones over all that a fit may reach, None where midpoints between those
    starts do. `fastest_rate(p)` is the angular frequency (rad/s) that the integration must resolve for the sake of the
    effect, None where the motion's own does. `nonsmooth` forces want a finer step; the state of one with memory follows the
    motion over the displacement (m) that it `gives_way(p)` within, and no longer step goes farther; where that is None, its
    steps are never longer. A `proportional` force grows with the motion as a whole, so that it changes frequency and loss
    alike at all amplitudes, and leaves the centre where it is. A `linear_part` is built into the simulator. What
    `may_be_all_of` a linear part has the strength of that part on a rig where nothing else adds to it, and then no constant
    of its own. A joint or an asperity holds no more than it gives way at: its first state is a share of that, at most
    `largest_state`. Other states are displacements, their second speeds, of any size. `beats_with(p, frequency)` checks that
    they swing so near an angular frequency (rad/s) that both read as one motion that beats.
    """

    kind = "physics"
    force: Any = None
    friction: Any = None
    rates: Any = None
    equilibrium_state: Callable[[float, Array], tuple[float, float]] | None = None
    states: int = 0
    largest_state: float = inf
    fading_memory: bool = True
    shared_parameters: Mapping[str, Callable[[float], float]] = field(default_factory=dict)
    starts: Callable[[Scales], Starts] = field(default=lambda scales: ((),))
    reach: Callable[[Scales], Starts] | None = None
    fastest_rate: Callable[[Array], float] | None = None
    gives_way: Callable[[Array], float] | None = None
    nonsmooth: bool = False
    proportional: bool = False
    beats_with: Callable[[Array, float], bool] | None = None
    linear_part: LinearPart | None = None
    may_be_all_of: LinearPart | None = None

    def __post_init__(self) -> None:
        for name in ("force", "friction", "rates"):
            if isinstance(getattr(self, name), FunctionType):
                object.__setattr__(self, name, effect_function(getattr(self, name)))

    @property
    def relative(self) -> bool:
        """Whether the strength is a share of another effect's parameter, so that no mass divides it."""
        return bool(self.shared_parameters)

    def starting_values(self, scales: Scales, channel: str = "") -> Starts:
        """Return starting values of the inner parameters that no variant holds."""
        return self.starts(scales)

    def close_starting_values(self, scales: Scales, channel: str = "") -> Starts:
        """Return close starting values of the inner parameters over all that a fit may reach."""
        return super().close_starting_values(scales, channel) if self.reach is None else self.reach(scales)

    def table(self, values: Mapping[str, float], shared: Mapping[str, float]) -> Numbers:
        """Return the parameters as compiled functions take them: own values by name, shared ones by "effect.parameter".

        Raises ValueError that names a parameter without a value.
        """
        missing = [p.name for p in self.parameters if p.name not in values]
        missing += [name for name in self.shared_parameters if name not in shared]
        if missing:
            raise ValueError(f"{self.name} needs a value of {', '.join(missing)}")
        given = [float(values[p.name]) for p in self.parameters] + [
            float(shared[n]) for n in self.shared_parameters
        ]
        return tuple(given + [0.0] * (PARAMETERS - len(given)))

    def state_sizes(self, amplitude: float, frequency: float) -> tuple[float, float]:
        """Return the sizes of the internal states in a motion of an amplitude (m) and angular frequency (rad/s)."""
        return (1.0, 1.0) if isfinite(self.largest_state) else (amplitude, amplitude * frequency)

    def states_at_rest(self, u: float, p: Numbers | Array) -> tuple[float, float]:
        """Return the internal states of a mass that has been held at `u` for long; zeros where nothing settles."""
        return (0.0, 0.0) if self.equilibrium_state is None else self.equilibrium_state(u, np.asarray(p))

    def states_along(
        self,
        p: Numbers,
        time: Array,
        u: Array,
        v: Array,
        start: tuple[float, float],
        *,
        steps: int = _STEPS,
    ) -> Array:
        """Return the internal states (n, 2), driven along a measured motion (n,) from `start`; zeros without memory."""
        if self.rates is None:
            return np.zeros((len(u), STATES))
        return cast(Array, states_along(address_of(self.rates, RATES), time, u, v, p, start, steps))

    @np.errstate(over="ignore", invalid="ignore")  # of states that diverge
    def periodic_states(
        self,
        p: Numbers,
        time: Array,
        u: Array,
        v: Array,
        start: tuple[float, float],
        scale: tuple[float, float],
    ) -> tuple[Array, bool]:
        """Return the internal states (n, 2) along a smooth turn (n,) that brings them back, and whether it does.

        States of size `scale` are sought from `start` by turning round and by Newton's method on the map of one turn, which
        serves contracting and lightly damped states alike. A step of Newton's method that comes less near is not taken.
        """

        def turn(begun: Array) -> tuple[Array, Array, float]:
            states = self.states_along(p, time, u, v, (begun[0], begun[1]), steps=1)
            missed = states[-1] - begun
            return states, missed, float(np.max(np.abs(missed) / scale))

        kept, nudges = slice(self.states), 1e-4 * np.diag(scale)[: self.states]
        states, missed, off = turn(np.array(start))
        for k in range(_MOST_TURNS):
            if off < _SETTLED:
                return states, True
            begun = states[-1].copy()
            states, missed, off = turn(begun)
            if off >= _SETTLED and k % _TURNS_TO_NEWTON == 0:
                slopes = [(missed - turn(begun + nudge)[1])[kept] / nudge.sum() for nudge in nudges]
                with suppress(np.linalg.LinAlgError):  # a state that every turn moves alike
                    begun[kept] += np.linalg.solve(np.transpose(slopes), missed[kept])
                near = turn(begun)
                states, missed, off = near if near[2] < off else (states, missed, off)
        return states, False

    def smooth_force_along(self, p: Numbers, time: Array, u: Array, v: Array, states: Array) -> Array:
        """Return the force without dry friction, m/s^2, shape (n,)."""
        return _values_along(self.force, p, time, u, v, states)

    def force_along(self, p: Numbers, time: Array, u: Array, v: Array, states: Array) -> Array:
        """Return the force, m/s^2, along a motion and its internal states, shape (n,)."""
        level = _values_along(self.friction, p, time, u, v, states)
        return self.smooth_force_along(p, time, u, v, states) + level * np.sign(v)


def _values_along(function: Any, p: Numbers, time: Array, u: Array, v: Array, states: Array) -> Array:
    """Evaluate a compiled function along a motion, (n,); zeros for None."""
    if function is None:
        return np.zeros(len(u))
    return cast(Array, values_along(address_of(function), time, u, v, states, p))
