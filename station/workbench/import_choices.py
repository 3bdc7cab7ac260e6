"""What the operator may say about a file that does not explain itself: columns, units, rate, mass."""

import re

from nicegui import ui

from station.exits import UsageProblem

Choices = tuple[dict[str, str | int], dict[str, str], float | None, float | None]

QUANTITIES = ("time", "displacement", "velocity", "acceleration", "force")


class ImportChoices:
    """Four fields that stay folded until they are needed."""

    def build(self) -> None:
        """Make the fields."""
        with ui.expansion("Options for odd files").props("dense dense-toggle").classes("small"):
            self._columns = _field("Columns", "displacement=phi, time=1")
            self._units = _field("Units", "displacement=rad")
            self._rate = ui.number("Rate, Hz", min=0).props("dense outlined")
            self._mass = ui.number("Mass, kg", min=0).props("dense outlined")

    def given(self) -> Choices:
        """Return what was typed; UsageProblem, in a sentence, where it cannot be read."""
        columns = _pairs("Columns", self._columns.value or "")
        return (
            {name: int(value) if value.isdigit() else value for name, value in columns.items()},
            _pairs("Units", self._units.value or ""),
            self._rate.value or None,
            self._mass.value or None,
        )


def _field(label: str, example: str) -> ui.input:
    return ui.input(label, placeholder=example).props("dense outlined spellcheck=false autocomplete=off")


def _pairs(label: str, text: str) -> dict[str, str]:
    """Return "displacement=phi, time=1" as a dictionary."""
    found = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, sign, value = (piece.strip() for piece in part.partition("="))
        if not sign or not value or name not in QUANTITIES:
            raise UsageProblem(
                f"{label}: '{part}' is not QUANTITY=VALUE, as displacement=phi; quantities are {', '.join(QUANTITIES)}"
            )
        found[name] = value
    return found


def for_the_page(sentence: str) -> str:
    """Return a sentence about an import that names the fields of the page where it names options of the command."""
    said = re.sub(r"--column ", "Columns: ", sentence)
    said = re.sub(r"--unit ", "Units: ", said)
    return re.sub(r"--rate\b", "Rate", said)
