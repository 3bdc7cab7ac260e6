"""How to capture: durations, rate, trigger, limits; refused in words when out of range."""

from dataclasses import dataclass, field

from daq.errors import OperatorError
from daq.session_info import SessionInfo

MIN_PRE_TRIGGER_S = 0.5


@dataclass(frozen=True)
class CaptureSettings:
    """How to capture. Times in s; `rate_hz` 0 leaves the rate to the board.

    `trigger_level` is the smallest swing taken for a release, in the unit of the displacement (of the
    velocity or acceleration where there is none); None takes one per cent of its range or 30 times its
    noise. `lost_limit` is the share of samples that may stay lost. With `wait_for_release` False the
    recording begins when the rest is over. `check_clock` compares the rate with this computer's clock. `release_from` (m)
    lets the rig take the mass there and release it; None waits for a hand.
    """

    duration_s: float = 8.0
    rate_hz: float = 256.0
    pre_trigger_s: float = 1.0
    rest_s: float = 1.0
    rest_timeout_s: float = 30.0
    trigger_timeout_s: float = 60.0
    trigger_level: float | None = None
    wait_for_release: bool = True
    lost_limit: float = 0.02
    check_clock: bool = True
    release_from: float | None = None
    info: SessionInfo = field(default_factory=SessionInfo)

    def __post_init__(self) -> None:
        _within("duration", self.duration_s, 0.1, 3600, "s")
        _within("rate", self.rate_hz, 0, 1e6, "Hz")
        _within("pre-trigger", self.pre_trigger_s, MIN_PRE_TRIGGER_S, 60, "s")
        _within("rest", self.rest_s, 0.25, 60, "s")
        _within("time to come to rest", self.rest_timeout_s, 0.1, 3600, "s")
        _within("time to wait for a release", self.trigger_timeout_s, 0.1, 3600, "s")
        _within("limit of lost samples", self.lost_limit, 0, 1, "")
        if self.trigger_level is not None and not self.trigger_level > 0:
            raise OperatorError(f"the trigger level must be positive, not {self.trigger_level:g}")


def _within(what: str, value: float, low: float, high: float, unit: str) -> None:
    if not low <= value <= high:
        raise OperatorError(f"the {what} must be {low:g} to {high:g} {unit}".rstrip() + f", not {value:g}")
