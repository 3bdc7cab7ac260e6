"""Text of strangers made harmless for a terminal: names in a session or from a board may hold escape sequences."""

from collections.abc import Iterable

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

CONTROL = [*range(0x09), *range(0x0B, 0x20), *range(0x7F, 0xA0)]
#: Characters that turn the direction of the text that follows, so that it reads as something else.
DIRECTION = [*range(0x202A, 0x202F), *range(0x2066, 0x206A)]
REPLACED = dict.fromkeys([*CONTROL, *DIRECTION], "\N{REPLACEMENT CHARACTER}")


def harmless(text: str) -> str:
    """Return `text` with every control character but tab and line feed replaced by a mark."""
    return text.translate(REPLACED)


class SafeConsole(Console):
    """A console whose own colours reach the terminal and whose texts cannot command it."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Yield the segments with harmless text; those by which rich steers the terminal pass."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(harmless(segment.text), segment.style)
