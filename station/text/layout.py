"""Small parts of what is printed: a line with its label, a sentence with its capital letter and full stop."""

from rich.table import Table
from rich.text import Text

from station.text.numbers import typeset


def labelled(label: str, text: str, width: int, style: str = "") -> Table:
    """Return a line with its label in a column of `width` characters before it."""
    line = Table.grid(padding=(0, 1))
    line.add_column(width=width)
    line.add_column(overflow="fold")
    line.add_row(Text(f" {label}", style="cyan"), Text(typeset(text), style=style))
    return line


def sentence(text: str) -> str:
    """Return a clause as a sentence; nothing where there is none."""
    return f"{text[0].upper()}{text[1:]}." if text else ""
