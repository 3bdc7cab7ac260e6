"""A joint or an asperity that gives way: a spring whose state is a share of what it gives way at."""

from math import copysign

from identify.arrays import Array
from identify.effects.compiled import force_function


@force_function
def joint_force(t, u, v, z, p):  # type: ignore[no-untyped-def]
    """Return the force of stiffness p[0] that gives way at p[1], at the state z[0]."""
    return p[0] * p[1] * z[0]


def held_state(u: float, p: Array) -> tuple[float, float]:
    """Return the states of a joint that has been held at u (m) for long: u over what it gives way at, p[1] (m), 1 at most.

    One that gives way at nothing has no force; its state is 0.
    """
    gives_way = float(p[1])
    return copysign(min(abs(u) / gives_way, 1.0), u) if gives_way > 0.0 else 0.0, 0.0
