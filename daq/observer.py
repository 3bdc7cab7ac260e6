"""The observer of a capture or a replay: called with states, samples and losses as they come."""

from daq.recording import Array, Channel, Gap
from firmware_protocol import Hello


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
