"""A result for people: a headline, and parts in plain text; terminal, page, viewer and report only render them."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Literal, Protocol

Rows = tuple[tuple[str, ...], ...]
Tone = Literal["good", "bad", "unsure", ""]


@dataclass(frozen=True)
class Facts:
    """Labels with the text of each."""

    rows: tuple[tuple[str, str], ...]
    kind: ClassVar[str] = "facts"


@dataclass(frozen=True)
class Paragraph:
    """A paragraph; `label` stands before it, `strong` frames it."""

    text: str
    label: str = ""
    strong: bool = False
    kind: ClassVar[str] = "paragraph"


@dataclass(frozen=True)
class Table:
    """A table with its head; the first `texts` columns are words, the others numbers.

    `marks` say what each row is: "named", "weak", "noise", "present", "above", "bad", "unsure", or "" for nothing special.
    """

    caption: str
    head: tuple[str, ...]
    rows: Rows
    texts: int = 1
    marks: tuple[str, ...] = ()
    kind: ClassVar[str] = "table"

    @property
    def marked(self) -> Iterable[tuple[str, tuple[str, ...]]]:
        """Each row after its mark."""
        return zip(self.marks or ("",) * len(self.rows), self.rows, strict=True)


class Drawn(Protocol):
    """A picture that a page can hold."""

    @property
    def uri(self) -> str:
        """The picture as a data URI."""


@dataclass(frozen=True)
class Figure:
    """A picture with its caption."""

    caption: str
    picture: Drawn
    kind: ClassVar[str] = "figure"


@dataclass(frozen=True)
class Equation:
    """An equation in plain letters, and the same with numbers."""

    lines: tuple[str, ...]
    kind: ClassVar[str] = "equation"


Part = Facts | Paragraph | Table | Figure | Equation


@dataclass(frozen=True)
class Told:
    """A result: its headline and how good it is (`tone`), what everybody reads, and what `--full` and the report add."""

    headline: str
    tone: Tone
    brief: tuple[Part, ...]
    more: tuple[Part, ...] = ()


def facts(rows: Iterable[tuple[str, str]]) -> tuple[Facts, ...]:
    """Make one part of the rows that have a text; none where no row has any."""
    kept = tuple((label, text) for label, text in rows if text)
    return (Facts(kept),) if kept else ()


def left_out(reason: str, label: str = "") -> Paragraph:
    """Write the paragraph that replaces a part of a report."""
    return Paragraph(f"Left out: {reason.rstrip('.')}.", label)


def markdown(parts: Iterable[Part]) -> str:
    """Write parts as markdown; pictures are left out."""
    blocks = []
    for part in parts:
        match part:
            case Facts():
                blocks += [f"**{label}**: {text}" if label else text for label, text in part.rows]
            case Table():
                rule = ["---" if n < part.texts else "---:" for n in range(len(part.head))]
                lines = [f"| {' | '.join(row)} |" for row in (part.head, tuple(rule), *part.rows)]
                blocks.append("\n".join(([f"**{part.caption}**", ""] if part.caption else []) + lines))
            case Paragraph():
                blocks.append(f"**{part.label}**: {part.text}" if part.label else part.text)
            case Equation():
                blocks += [f"`{line}`" for line in part.lines]
    return "\n\n".join(blocks)
