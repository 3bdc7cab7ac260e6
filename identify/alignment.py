"""Alignment: the lag and the gain between two channels, by kinematics alone."""

from dataclasses import dataclass

from identify.estimate import Estimate


@dataclass(frozen=True)
class Alignment:
    """How the displacement (or velocity) channel stands to the acceleration channel.

    `lag` in s is positive when the displacement is late. `gain` is the acceleration's gain relative to
    the second derivative of the displacement (1 when the calibrations agree), dimensionless.
    `method` names how it was found; `caution` is a sentence when the answer is weaker than usual, or "".
    """

    lag: Estimate
    gain: Estimate
    method: str
    caution: str = ""
