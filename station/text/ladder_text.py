"""The ladder in the terminal: step by step what was added, the three errors, what changed; the floor comes last."""

import math

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from station.results.ladder import KeptLadder, KeptStep
from station.story.engineering_values import Weighing
from station.story.residual import floor_words, times
from station.text.layout import sentence
from station.text.numbers import change, three_figures, with_unit

MOST_CHANGED = 3
NOTICED = 2.0


def show_ladder(console: Console, name: str, ladder: KeptLadder, weighing: Weighing | None = None) -> None:
    """Print the ladder of a session up to the present step, and which steps are above it.

    With a `weighing` the strengths that changed stand in N, kg and s beside those per unit mass.
    """
    console.print()
    console.print(Text(f" {name}: the error, step by step", style="bold"))
    console.print()
    console.print(Padding(_table(ladder), (0, 0, 0, 1)))
    console.print()
    for line in _below(ladder, weighing):
        console.print(Padding(Text(line), (0, 1)))
    console.print()


def _table(ladder: KeptLadder) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("step", justify="right")
    table.add_column("effect", no_wrap=True)
    table.add_column("residual, %\nof the motion", justify="right")
    table.add_column("times the\nnoise", justify="right", no_wrap=True)
    table.add_column("change", justify="right")
    before: KeptStep | None = None
    for place, step in enumerate(ladder.steps):
        above = place > ladder.present
        style = "dim" if above else "bold" if place == ladder.present else ""
        error = step.error
        cells = (
            str(place),
            step_words(step),
            three_figures(error.motion_percent),
            times(error.chi2),
            "" if before is None else change(before.error.times_noise, error.times_noise),
        )
        table.add_row(*(Text(cell, style=style) for cell in cells))
        before = step
    floor = (
        "",
        "noise alone",
        three_figures(ladder.floor.motion_percent),
        floor_words(ladder.top.chi2_std),
        "",
    )
    table.add_row(*(Text(cell, style="green") for cell in floor))
    return table


def step_words(step: KeptStep) -> str:
    """Return what a step did to the model."""
    if step.added:
        return f"+ {step.added}"
    if step.removed:
        return f"- {step.removed}"
    return step.began


def changed_parameters(before: KeptStep, after: KeptStep, weighing: Weighing | None = None) -> list[str]:
    """Return the parameters that the step changed most, in standard errors of the fit before, and those it added."""
    found = []
    weighed = {} if weighing is None else _beside(after, weighing)
    for name, value in after.parameters.items():
        old = before.parameters.get(name)
        if old is None:
            found.append((math.inf, f"{name} = {with_unit(value)}{weighed.get(name, '')}, new"))
            continue
        std = max(old.std or 0.0, value.std or 0.0)
        errors = abs(value.value - old.value) / std if std > 0 else 0.0
        if errors > NOTICED:
            by = ", ".join(filter(None, (change(old.value, value.value), f"{errors:.0f} std. errors")))
            found.append((errors, f"{name} {with_unit(value)}{weighed.get(name, '')} ({by})"))
    found.sort(key=lambda entry: -entry[0])
    new = sum(1 for weight, _ in found if math.isinf(weight))
    return [text for _, text in found[: new + MOST_CHANGED]]


def _beside(step: KeptStep, weighing: Weighing) -> dict[str, str]:
    return {name: f", with the mass {words}" for name, words in with_mass(step, weighing).items()}


def with_mass(step: KeptStep, weighing: Weighing) -> dict[str, str]:
    """Return the strengths of a step with the mass in them, as "13012 ± 2 N/m", by "effect.parameter"."""
    found = {}
    for entry in step.model.effects:
        name, value = next(iter(entry.parameters.items()), (None, None))
        if name is None or value is None:
            continue
        whole = weighing.strength(entry.effect, value.value, value.std, value.unit)
        if whole is not None:
            found[f"{entry.effect}.{name}"] = with_unit(whole)
    return found


def _below(ladder: KeptLadder, weighing: Weighing | None) -> list[str]:
    lines = []
    if ladder.present > 0:
        before = ladder.steps[ladder.present - 1]
        lines += [f"changed: {text}" for text in changed_parameters(before, ladder.top, weighing)]
    if ladder.stopped_because:
        lines.append(sentence(ladder.stopped_because))
    above = len(ladder.steps) - 1 - ladder.present
    if above:
        lines.append(f"{above} step{'s' if above > 1 else ''} above: `--to N` goes there, adding drops them.")
    return lines
