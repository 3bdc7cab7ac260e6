"""The release: where in a record the motion becomes free."""

from dataclasses import dataclass
from typing import Literal

ReleaseKind = Literal["displaced", "impulse", "in_motion"]


@dataclass(frozen=True)
class Release:
    """Where the motion becomes free.

    `time_s` (sub-sample, from the first sample) and its standard error `std_s`; `index` is the first
    sample of free motion; `settle` is the first sample at which the hand has surely let go (use it as the start of
    fits); `end` is one past the last sample of motion (after it the mass is stuck, or the record ends).
    `kind` is "displaced" (held away from zero, then let go), "impulse" (an initial velocity) or
    "in_motion" (the record begins in mid-decay). `rest` is the half-open range of samples at rest
    before it, (0, 0) when there is none.
    """

    time_s: float
    std_s: float
    index: int
    settle: int
    end: int
    kind: ReleaseKind
    rest: tuple[int, int]
