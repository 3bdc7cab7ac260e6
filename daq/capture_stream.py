"""The stream of a capture: blocks as they arrive, passed to an observer; a board that fails in it raises."""

import time
from collections.abc import Iterator

from daq.decode import Block
from daq.errors import BoardError, LinkLost
from daq.link import GIVE_UP_S, WARN_S, Link, is_noisy
from daq.recording import Array, Channel, Gap
from firmware_protocol import Hello, HelloRequest, OtherVersion


class CaptureObserver:
    """Called during a capture, in the thread that captures; override what is of interest."""

    def connected(self, hello: Hello, channels: tuple[Channel, ...]) -> None:
        """The board answered and described its channels."""

    def state(self, name: str, detail: str) -> None:
        """Where the capture stands: resting, holding, armed, triggered, recording, resending, sealed; and a sentence.

        Called again with another detail for what is no new state, such as a silence.
        """

    def block(self, first_index: int, samples: Array) -> None:
        """Samples from `first_index` on, shape (channels, n), SI units."""

    def loss(self, gap: Gap) -> None:
        """Samples that did not arrive; some of them may still be had by asking again."""


class CaptureStream:
    """Blocks from `link` for one caller, with a limit to the board's silence; `state` names the capture's step.

    Every block and every loss goes to `observer` as it arrives. `kept` says what becomes of what was received.
    """

    def __init__(
        self, link: Link, observer: CaptureObserver, kept: str = "what was received is kept"
    ) -> None:
        self._link = link
        self._kept = kept
        self._observer = observer
        self._step = "resting"
        self._hellos = 0
        self._last_block = time.monotonic()
        self._blocks: list[Block] = []
        link.on_event = self._on_event

    def state(self, step: str, detail: str) -> None:
        """Say to the observer which step begins."""
        self._step = step
        self._observer.state(step, detail)

    def start(self) -> None:
        """Send START; silence counts from here."""
        self._link.start()
        self._last_block = time.monotonic()

    def during(self, seconds: float) -> Iterator[Block]:
        """Yield blocks for so many seconds by this computer's clock or the board's, whichever is over first."""
        assembly = self._link.assembly
        until, last = time.monotonic() + seconds, assembly.expected + seconds * assembly.rate
        while time.monotonic() <= until and assembly.expected <= last:
            yield from self._next_blocks()

    def skip(self) -> None:
        """Forget the blocks that came while nobody asked for them."""
        self._blocks = []

    def take_to(self, sample: int, seconds: float) -> None:
        """Take what arrives up to a sample index, for at most so many seconds by this computer's clock."""
        until = time.monotonic() + seconds
        while self._link.assembly.expected < sample and time.monotonic() <= until:
            self._next_blocks()

    def _next_blocks(self) -> list[Block]:
        """Take what arrives next; raise when the board is silent, gone, rebooted or contradicts itself."""
        frame = self._link.take(0.05)
        if frame is not None and isinstance(frame.message, OtherVersion):
            raise BoardError("the board changed its protocol version in mid-capture; reset it")
        if self._link.assembly.contradictions:
            what = self._link.assembly.contradictions[-1]
            raise BoardError(f"{what}; {self._kept}, its firmware needs a correction")
        if self._link.assembly.rebooted:
            raise LinkLost(f"the board rebooted in mid-capture; {self._kept}. Check its supply")
        self._watch_silence()
        blocks, self._blocks = self._blocks, []
        return blocks

    def _watch_silence(self) -> None:
        """Announce a silence at 0.5 s and give up at 2 s; a board that talks but sends no samples is silent too."""
        silence = time.monotonic() - self._last_block - 2 / self._link.assembly.rate
        if silence < WARN_S:
            self._hellos = 0
            return
        if silence > GIVE_UP_S:
            raise LinkLost(self._why_silent())
        if not self._hellos:
            self._observer.state(self._step, f"nothing came for {WARN_S:g} s")
        if silence > WARN_S * (self._hellos + 1):
            self._hellos += 1
            self._link.send(HelloRequest(), prefix=b"\0")

    def _why_silent(self) -> str:
        kept = self._kept
        if self._link.silence() > WARN_S and is_noisy(self._link.statistics):
            return f"only noise has come for {GIVE_UP_S:g} s; {kept}. Check cable and baud rate"
        if self._link.silence() > WARN_S:
            return (
                f"the board has been silent for {GIVE_UP_S:g} s; {kept}. Check cable and board, or reset it"
            )
        clock, rate = self._link.assembly.samples.host_clock(), self._link.assembly.rate
        if clock is not None and clock.rate < 0.9 * rate:
            return (
                f"only {clock.rate:.0f} of {rate:g} samples per second came, then none for"
                f" {GIVE_UP_S:g} s; {kept}. The line is too slow for this rate"
            )
        return f"the board talks but sent no samples for {GIVE_UP_S:g} s; {kept}. Reset it"

    def _on_event(self, event: Block | Gap) -> None:
        if isinstance(event, Gap):
            self._observer.loss(event)
            return
        self._last_block = time.monotonic()
        self._blocks.append(event)
        self._observer.block(event.first, event.samples)
