"""The limits of a capture: bytes of log, room on the disk, seconds; checked before START."""

from dataclasses import dataclass

from daq.capture_settings import CaptureSettings
from daq.errors import OperatorError
from daq.raw_log import MAX_LOG

BOOT_S = 3.0
HELLO_FOR_S = 5.0
ANSWER_S = (0.25, 0.5, 1.0, 2.0)
END_S = 30.0
RESEND_FOR_S = 30.0
HOLD_FOR_S = 60.0

SPARE_BYTES = 1 << 20
LARGEST_OVERHEAD, SMALLEST_OVERHEAD = 80, 1.08
"""Bytes of a sample that is sent in a frame and logged in a record of its own; share of frames that are full."""
SLACK_BYTES = 1 << 22


@dataclass(frozen=True)
class Budget:
    """Of a capture at `rate` Hz with `sample_bytes` of numbers a sample, all channels together."""

    settings: CaptureSettings
    rate: float
    sample_bytes: int

    @property
    def sampling_s(self) -> float:
        """The longest time that the board samples, by its own clock: every wait to its end.

        A rig that releases itself moves, and rests twice.
        """
        s = self.settings
        rest = s.rest_timeout_s if s.release_from is None else 2 * s.rest_timeout_s + HOLD_FOR_S
        return rest + s.pre_trigger_s + s.trigger_timeout_s + s.duration_s

    @property
    def disk(self) -> int:
        """Bytes that must be free: twice what the samples take in their widest format."""
        s = self.settings
        seconds = s.rest_s + s.pre_trigger_s + s.trigger_timeout_s + s.duration_s
        return SPARE_BYTES + round(2 * self.rate * max(self.sample_bytes, 16) * seconds)

    def require(self) -> int:
        """Return the most bytes that the log may take; OperatorError when full frames alone would not fit a session."""
        least = self.rate * self.sampling_s * self.sample_bytes * SMALLEST_OVERHEAD
        if least > MAX_LOG - SLACK_BYTES:
            raise OperatorError(
                f"at {self.rate:g} Hz this capture may take {least / 1e9:.3g} GB in {self.sampling_s:g} s, more than"
                f" the {MAX_LOG / 1e9:.3g} GB of a session; ask for a lower rate, or for shorter waits and duration"
            )
        most = 2 * self.rate * self.sampling_s * (self.sample_bytes + LARGEST_OVERHEAD)
        return min(SLACK_BYTES + round(most), MAX_LOG - SLACK_BYTES)
