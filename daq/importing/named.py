"""A column by what an operator calls it: its name, roughly, or its number."""

import re
from collections.abc import Sequence

from daq.importing.errors import problem
from daq.importing.table import SourceColumn, Table


def named(table: Table, wanted: str | int, what: str) -> SourceColumn:
    """Return the one column that is called so, for a quantity. Raises ImportProblem where there is none, or several."""
    text = _plain(str(wanted))
    tests = (
        lambda c: c.label == str(wanted),
        lambda c: str(c.number) == str(wanted).strip(),
        lambda c: _plain(c.label) == text != "",
        lambda c: _plain(c.label).split()[:1] == [text],
        lambda c: len(text) > 2 and text in _plain(c.label),
    )
    for test in tests:
        found = [c for c in table.columns if test(c)]
        if len(found) == 1:
            return found[0]
        if found:
            raise problem(
                table.path, f"'{text}' could be {listed(found)}", f"give its number, as {found[0].number}"
            )
    noun = table.columns[0].noun if table.columns else "column"
    raise problem(
        table.path, f"there is no {noun} '{wanted}' for the {what}; the file has {listed(table.columns)}",
        "name one of these, or give its number",
    )  # fmt: skip


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", " ", name).strip().casefold()


def listed(columns: Sequence[SourceColumn]) -> str:
    """Return the first columns as a sentence names them."""
    shown = ", ".join(c.place for c in columns[:8])
    return shown + (f" and {len(columns) - 8} more" if len(columns) > 8 else "")
