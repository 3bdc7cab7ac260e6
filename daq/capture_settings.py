"""How to capture: durations, rate, trigger, and the bytes that it may take; refused in words when out of range."""

from dataclasses import dataclass, field

from daq.errors import OperatorError
from daq.raw_log import MAX_LOG
from daq.rig import HOLD_FOR_S
from daq.session_info import SessionInfo

MIN_PRE_TRIGGER_S = 0.5
SPARE_BYTES = 1 << 20
LARGEST_OVERHEAD, SMALLEST_OVERHEAD = 80, 1.08
"""Bytes of a sample that is sent in a frame and logged in a record of its own; share of frames that are full."""
SLACK_BYTES = 1 << 22


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

    def disk_bytes(self, rate: float, sample_bytes: int) -> int:
        """Return how many bytes must be free: twice what samples of so many bytes at `rate` Hz take, widest format."""
        seconds = self.rest_s + self.pre_trigger_s + self.trigger_timeout_s + self.duration_s
        return SPARE_BYTES + round(2 * rate * max(sample_bytes, 16) * seconds)

    def log_bytes(self, rate: float, sample_bytes: int) -> int:
        """Return the most bytes that the log may take, every wait lasting to its end.

        A rig that releases itself moves, and rests twice. OperatorError when full frames alone would not fit a session.
        """
        rest = self.rest_timeout_s if self.release_from is None else 2 * self.rest_timeout_s + HOLD_FOR_S
        seconds = rest + self.pre_trigger_s + self.trigger_timeout_s + self.duration_s
        least = rate * seconds * sample_bytes * SMALLEST_OVERHEAD
        if least > MAX_LOG - SLACK_BYTES:
            raise OperatorError(
                f"at {rate:g} Hz this capture may take {least / 1e9:.3g} GB in {seconds:g} s, more than the"
                f" {MAX_LOG / 1e9:.3g} GB of a session; ask for a lower rate, or for shorter waits and duration"
            )
        most = 2 * rate * seconds * (sample_bytes + LARGEST_OVERHEAD)
        return min(SLACK_BYTES + round(most), MAX_LOG - SLACK_BYTES)


def _within(what: str, value: float, low: float, high: float, unit: str) -> None:
    if not low <= value <= high:
        raise OperatorError(f"the {what} must be {low:g} to {high:g} {unit}".rstrip() + f", not {value:g}")
