"""A sound card as a source: a sensor at line-in, through `sounddevice`.

A line-in is coupled by a capacitor: it passes nothing below some Hz, and its full scale is not a calibrated voltage.
Both are said to the operator. The clock is the card's, and good.
"""

import queue
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from daq.errors import OperatorError, PortError
from daq.importing.options import QUANTITIES
from daq.importing.units import parse_scaled_unit
from daq.recording import Array, Channel
from daq.sources.source import Reading, SourceDescription

WAIT_S = 0.05
BLOCK_S = 0.02


class AudioInput:
    """Channels of a sound card's input: `units` gives what full scale is ("95 m/s^2") for each quantity, in order."""

    def __init__(self, device: str | None, rate_hz: float, units: Mapping[str, str]) -> None:
        try:
            import sounddevice
        except (ImportError, OSError) as error:  # OSError: the library is there, PortAudio is not
            raise PortError(
                f"a sound card needs the package sounddevice and PortAudio ({error}); install them with: "
                "pip install 'free-decay-station[audio]'"
            ) from error
        self._library: Any = sounddevice
        self._device = int(device) if device and device.isdigit() else device or None
        self._channels = _channels(units)
        self._scales: Array = np.array([channel.high for channel in self._channels])
        self._rate = rate_hz
        self._blocks: queue.SimpleQueue[tuple[Array, bool]] = queue.SimpleQueue()
        self._stream: Any = None
        self._count = 0

    def describe(self) -> SourceDescription:
        """Return the channels; the card is asked whether it has them at this rate. Raises PortError where it has not."""
        try:
            self._library.check_input_settings(
                device=self._device, channels=len(self._channels), samplerate=self._rate
            )
        except Exception as error:
            raise PortError(
                f"the sound card does not give {len(self._channels)} inputs at {self._rate:g} Hz: {error}"
            ) from error
        remarks = (
            "a sound card's input is AC coupled: slow motion and offsets are missing from it, and its full scale is "
            "as you gave it, not calibrated",
        )
        return SourceDescription(
            f"sound card {self._device or ''}".strip(), self._channels, self._rate, remarks
        )

    def start(self) -> None:
        """Open the input; sample 0 is the first that comes."""
        self.close()
        self._count = 0
        self._stream = self._library.InputStream(
            device=self._device,
            channels=len(self._channels),
            samplerate=self._rate,
            dtype="float32",
            blocksize=max(1, round(BLOCK_S * self._rate)),
            callback=self._arrived,
        )
        self._stream.start()

    def read(self) -> Sequence[Reading]:
        """Return the samples that have come."""
        found = []
        try:
            block, overflowed = self._blocks.get(timeout=WAIT_S)
            while True:
                self._count += overflowed  # at least one sample is missing before this block
                found.append(Reading(self._count, block * self._scales))
                self._count += len(block)
                block, overflowed = self._blocks.get_nowait()
        except queue.Empty:
            return found

    def close(self) -> None:
        """Stop the input."""
        if self._stream is not None:
            self._stream.stop()
            self._stream.close()
            self._stream = None

    def _arrived(self, block: Array, frames: int, when: object, status: Any) -> None:
        self._blocks.put((np.array(block, dtype=np.float64), bool(status.input_overflow)))


def _channels(units: Mapping[str, str]) -> tuple[Channel, ...]:
    if not units:
        raise OperatorError(
            "say what the input measures and what its full scale is, as --unit acceleration='95 m/s^2'"
        )
    channels = []
    for quantity, text in units.items():
        unit = parse_scaled_unit(text)
        if quantity not in QUANTITIES[1:] or unit is None or unit.quantity != quantity:
            raise OperatorError(
                f"--unit {quantity}={text}: say a {', '.join(QUANTITIES[1:])} and its full scale with a unit"
            )
        channels.append(Channel(quantity, quantity, unit.si, low=-unit.scale, high=unit.scale))
    return tuple(channels)
