"""A summary: how a result prints itself, in a screenful of text or as a small table in a notebook."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from textwrap import fill

WIDTH = 80


@dataclass(frozen=True)
class Summary:
    """A title, sentences, and a table: its head and its rows, a cell a text. The first column is set to the left.

    `then` is what follows below, None where nothing does.
    """

    title: str
    sentences: Sequence[str] = ()
    head: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    then: "Summary | None" = None

    def text(self) -> str:
        """Return the summary in lines of at most 80 characters (a table's row may be longer)."""
        parts = [self.title]
        parts += [fill(sentence, WIDTH) for sentence in self.sentences if sentence]
        if self.rows:
            parts.append("\n".join(self._lines()))
        if self.then is not None:
            parts.append(self.then.text())
        return "\n\n".join(parts)

    def _lines(self) -> list[str]:
        table = [tuple(self.head), *(tuple(row) for row in self.rows)]
        widths = [max(len(row[i]) for row in table) for i in range(len(self.head))]
        lines = []
        for first, *others in table:
            cells = [first.ljust(widths[0])]
            cells += [cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True)]
            lines.append("  ".join(cells).rstrip())
        return lines

    def html(self) -> str:
        """Return the summary as HTML, every text escaped."""
        parts = [f"<b>{escape(self.title)}</b>"]
        parts += [f"<p>{escape(sentence)}</p>" for sentence in self.sentences if sentence]
        if self.rows:
            head = "".join(f"<th>{escape(cell)}</th>" for cell in self.head)
            rows = "".join(
                "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in self.rows
            )
            parts.append(f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>")
        if self.then is not None:
            parts.append(self.then.html())
        return "".join(parts)


class Summarised:
    """A result that prints its summary, in a terminal and in a notebook, instead of all that it holds."""

    def brief(self) -> Summary:
        """Summarize the result for reading."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return self.brief().text()

    def _repr_html_(self) -> str:
        return self.brief().html()
