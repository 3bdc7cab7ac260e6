"""The layout of a result in a terminal of 80 columns, and a clause as a sentence."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.table import Table as Grid
from rich.text import Text

from identify.formatting import SPACE
from station.output import asked_for_json, next_line, print_json, screen
from station.text.content import Facts, Paragraph, Part, Table, Told

LABEL_WIDTH = 12
MOST_LINES, FEWEST = 12, 1
"""Lines that a result takes with the command that comes next, and the facts that are never left out for them."""

STYLES = {"good": "bold green", "bad": "bold red", "unsure": "bold yellow", "": "bold"}
MARKS = {
    **dict.fromkeys(("named", "present"), "bold"),
    **dict.fromkeys(("weak", "above"), "dim"),
    "noise": "green",
    "bad": "red",
    "unsure": "yellow",
}


def answer(document: dict[str, Any], told: Told, *following: str | Path, full: bool = False) -> None:
    """Print a result as one JSON object where that was asked for, else for people with the command that comes next."""
    if asked_for_json():
        print_json(document)
    else:
        console = screen()
        show(console, told, full=full)
        if following:
            console.print(next_line(*following), markup=False, soft_wrap=True)


def show(console: Console, told: Told, *, full: bool = False) -> None:
    """Print a result: its headline and what everybody reads; with `full` the rest."""
    if told.headline:
        console.print(_headline(told))
    show_parts(console, (*told.brief, *told.more) if full or not told.more else _within(console, told))


def _headline(told: Told) -> Padding:
    return Padding(Text(_plain(told.headline), style=STYLES[told.tone]), (0, 1))


def _within(console: Console, told: Told) -> tuple[Part, ...]:
    """Return the brief parts without the last facts where they would take too many lines; `--full` has them."""
    *parts, last = told.brief or (Facts(()),)
    while isinstance(last, Facts) and len(last.rows) > FEWEST:
        with console.capture() as lines:
            console.print(_headline(told))
            show_parts(console, (*parts, last))
        if lines.get().count("\n") < MOST_LINES:
            break
        last = Facts(last.rows[:-1])
    return (*parts, last)


def show_parts(console: Console, parts: Iterable[Part]) -> None:
    """Print parts one under another; pictures are left out."""
    for part in parts:
        match part:
            case Facts():
                for label, text in part.rows:
                    console.print(labelled(label, text))
            case Paragraph():
                words = f"{part.label}: {part.text}" if part.label else part.text
                console.print(Padding(Text(_plain(words)), (0, 1)))
            case Table():
                if part.caption:
                    console.print(Padding(Text(part.caption, style="bold"), (0, 1)))
                if any(part.head) or _fits(part, console.width - 1):
                    console.print(Padding(grid(part, console.width - 1), (0, 0, 0, 1)))
                    continue
                for row in part.rows:  # a path may be longer than a line, and is never folded
                    console.print(f" {_plain('  '.join(row))}", markup=False, soft_wrap=True)


def _fits(table: Table, width: int) -> bool:
    """Tell whether the columns stand beside each other, none of which has a word that takes half of the width."""
    columns = zip(*table.rows, strict=True)
    longest = [
        max((len(word) for cell in cells for word in _plain(cell).split()), default=0) for cells in columns
    ]
    return max(longest, default=0) <= width // 2 and sum(longest) + 2 * (len(longest) - 1) <= width


def grid(table: Table, width: int) -> Grid:
    """Set a table in columns; words are folded at blanks, and numbers only where the longest words leave them no room."""
    made = Grid(
        box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold", show_header=any(table.head)
    )
    columns = [[_plain(cell) for cell in cells] for cells in zip(table.head, *table.rows, strict=True)]
    texts = range(min(table.texts, len(columns)))
    widths = [_longest(cells, str.splitlines) for cells in columns]
    least = [_longest(columns[i], str.split) if i in texts else wide for i, wide in enumerate(widths)]
    width -= 2 * (len(columns) - 1)
    room = width >= sum(least)
    # What folds gives way, none below its longest word.
    for i in sorted(texts, key=lambda i: least[i] - widths[i]):
        widths[i] -= min(widths[i] - least[i], max(sum(widths) - width, 0))
    for i, (name, wide) in enumerate(zip(table.head, widths, strict=True)):
        made.add_column(
            Text(_plain(name)),
            justify="left" if i in texts else "right",
            overflow="fold",
            no_wrap=room and i not in texts,
            width=wide if room or i in texts else None,
        )
    for mark, row in table.marked:
        made.add_row(*(Text(_plain(cell), style=MARKS.get(mark, "")) for cell in row))
    return made


def _longest(cells: Sequence[str], parted: Callable[[str], list[str]]) -> int:
    return max((len(part) for cell in cells for part in parted(cell)), default=0)


def labelled(label: str, text: str) -> Grid:
    """Set a line with its label in a column before it."""
    line = Grid.grid(padding=(0, 1))
    line.add_column(width=LABEL_WIDTH)
    line.add_column(overflow="fold")
    line.add_row(Text(f" {label}", style="cyan"), Text(_plain(text)))
    return line


def _plain(text: str) -> str:
    """Write blanks that do not break as plain ones: what is copied from a terminal is typed into another program."""
    return text.replace(SPACE, " ")


def sentence(text: str) -> str:
    """Write a clause as a sentence; nothing where there is none."""
    return f"{text[0].upper()}{text[1:].rstrip('.')}." if text else ""
