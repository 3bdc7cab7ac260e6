"""The columns of a dropped file: its numbers, a small plot, and select boxes with the proposed choices."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nicegui import ui
from pydantic import ValidationError

from daq.importing.recipe import ROLES, Recipe
from station.exits import UsageProblem
from station.workbench import widgets
from station.workbench.parts import part
from station.workbench.view_models import ImportQuestion

UNITS = ("s", "ms", "us", "m", "mm", "um", "rad", "deg", "m/s", "deg/s", "m/s^2", "g", "N", "V", "counts")
"""The units that are offered; any other that is known may be typed."""


class ImportChoices:
    """The question about a file, which stands for all `files`; `answered` gives the recipe, `of_files` what else."""

    def __init__(self, question: ImportQuestion, files: Sequence[Path]) -> None:
        self._recipe = question.recipe
        self._boxes: list[tuple[ui.select, ui.select]] = []
        widgets.label(question.sentence, "small wrap")
        with ui.element("div").classes("asked"):
            for head in ("column", "first rows", "", "what it is", "in"):
                widgets.label(head, "small faint")
            for column, field in zip(question.columns, question.recipe.fields, strict=True):
                run = f", run {field.run}" if field.run else ""
                widgets.label(f"{column.place}{run}", "small strong wrap")
                widgets.label(column.numbers, "small faint wrap")
                widgets.html().content = part("sparkline", column.line)
                role = _select(f"Role of {column.place}", list(ROLES), field.role)
                units = list(dict.fromkeys(("", field.unit, *UNITS)))
                known = field.unit != "counts" or field.name  # of a column without a head it is a guess
                unit = _select(f"Unit of {column.place}", units, field.unit if known else "")
                unit.props("use-input hide-selected fill-input new-value-mode=add-unique")
                self._boxes.append((role, unit))
        rate = "Rate, Hz (in place of time stamps)"
        self._rate = widgets.number(rate, question.recipe.rate).props("clearable")
        self._of_files: list[ui.input] = []
        if len(files) > 1:
            widgets.label(
                f"The other {len(files) - 1} files are read alike, and all are looked at together.",
                "small wrap",
            )
            for said in (
                "Numbers in the names of files: {arm:d}P.txt takes 12 from 12P.txt as arm",
                "What varies between them, as stiffness,inertia",
            ):
                self._of_files.append(ui.input(said).props("dense outlined"))

    def of_files(self) -> tuple[str, ...]:
        """Return the form of the names of files, and what varies between them, as they are typed; nothing for one file."""
        return tuple(str(box.value or "") for box in self._of_files)

    def answered(self) -> Recipe:
        """Return the recipe as the boxes stand. Raises UsageProblem, in a sentence, where a unit does not fit a role."""
        said: dict[str, Any] = self._recipe.model_dump(by_alias=True)
        for field, (role, unit) in zip(said["fields"], self._boxes, strict=True):
            if field["unit"] and not unit.value and role.value not in ("ignored", "run"):
                raise UsageProblem(f"choose the unit of the {role.value}")
            field |= {"role": role.value, "unit": unit.value or ""}
        try:
            return Recipe.model_validate(said | {"rate": self._rate.value or None})
        except ValidationError as error:
            first = error.errors(include_url=False, include_input=False)[0]
            raise UsageProblem(first["msg"].removeprefix("Value error, ")) from None


def _select(name: str, options: list[str], value: str) -> ui.select:
    made = ui.select(options, value=value).props("dense outlined options-dense").classes("grow")
    made.props["aria-label"] = name
    return made
