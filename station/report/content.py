"""What a report is made of: sections that hold facts, paragraphs, tables and figures, all plain text but the pictures."""

from dataclasses import dataclass
from typing import ClassVar


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
    """A table with a repeated header; the first `texts` columns are words, the others numbers but for
    a last one of text, if it is `wordy`.
    """

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: int = 1
    wordy: bool = False
    kind: ClassVar[str] = "table"


@dataclass(frozen=True)
class Figure:
    """A picture as a data URI with its caption."""

    caption: str
    picture: str
    kind: ClassVar[str] = "figure"


@dataclass(frozen=True)
class Equation:
    """An equation in plain letters, and the same with numbers."""

    lines: tuple[str, ...]
    kind: ClassVar[str] = "equation"


def left_out(reason: str) -> Paragraph:
    """Return the paragraph that stands in place of a section."""
    return Paragraph(f"Left out: {reason.rstrip('.')}.")


Part = Facts | Paragraph | Table | Figure | Equation


@dataclass(frozen=True)
class Section:
    """One numbered section; `name` is its anchor."""

    name: str
    title: str
    parts: tuple[Part, ...]
