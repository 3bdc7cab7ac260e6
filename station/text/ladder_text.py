"""The ladder in words: for each step the effect added, the residual and what changed; the noise comes last."""

import math
from pathlib import Path

from daq.plain_text import counted
from identify.formatting import three_figures
from identify.residual import floor_words, noise_multiple, times
from station.results.ladder import KeptLadder, KeptStep
from station.story.engineering_values import Weighing
from station.text.content import Table, Told, facts
from station.text.layout import sentence
from station.text.numbers import change, typeset, with_unit

MOST_CHANGED = 2
NOTICED = 2.0


def told(ladder: KeptLadder, weighing: Weighing) -> Told:
    """Tell a ladder up to the present step, and which steps are above it."""
    changed: list[str] = []
    if ladder.present > 0:
        changed = changed_parameters(ladder.steps[ladder.present - 1], ladder.top, weighing)
    above = len(ladder.steps) - 1 - ladder.present
    steps = counted(above, "step", "steps")
    going = f"{steps}; `--to N` goes there, and adding an effect drops the steps above" if above else ""
    rows = [("changed" if not n else "", text) for n, text in enumerate(changed)]
    return Told(
        sentence(ladder.stopped_because) or "The residual, step by step",
        "good" if ladder.top.at_floor else "",
        (steps_table(ladder), *facts((*rows, ("above", going)))),
    )


def steps_table(ladder: KeptLadder) -> Table:
    """Make the table of the steps, with what noise alone leaves at its end."""
    rows, marks = [], []
    for place, step in enumerate(ladder.steps):
        error, before = step.error, ladder.steps[max(place - 1, 0)].error
        fell = change(noise_multiple(before.chi2), noise_multiple(error.chi2)) if place else ""
        rows.append(
            (str(place), step_words(step), three_figures(error.motion_percent), times(error.chi2), fell)
        )
        marks.append("above" if place > ladder.present else "present" if place == ladder.present else "")
    floor = floor_words(ladder.top.error.chi2_std)
    rows.append(("", "noise alone", three_figures(ladder.top.floor_percent), floor, ""))
    head = ("step", "effect", "% of motion", "times noise", "change")
    return Table("", head, tuple(rows), texts=2, marks=(*marks, "noise"))


def step_words(step: KeptStep) -> str:
    """Say what a step did to the model."""
    if step.added:
        return f"+ {step.added}"
    if step.removed:
        return f"- {step.removed}"
    return step.began


def changed_parameters(before: KeptStep, after: KeptStep, weighing: Weighing) -> list[str]:
    """List the parameters that the step added, and those that it changed most, in standard errors of the fit before."""
    found = []
    weighed = {name: with_unit(value) for name, value in after.weighed(weighing).items()}
    for name, value in after.model.parameters.items():
        old = before.model.parameters.get(name)
        if old is None:
            found.append((math.inf, f"{typeset(name)} = {weighed[name]}, new"))
            continue
        std = max(old.std or 0.0, value.std or 0.0)
        errors = abs(value.value - old.value) / std if std > 0 else 0.0
        if errors > NOTICED:
            by = ", ".join(filter(None, (change(old.value, value.value), f"{errors:.0f} std. errors")))
            found.append((errors, f"{typeset(name)} = {weighed[name]} ({by})"))
    found.sort(key=lambda entry: -entry[0])
    new = sum(1 for weight, _ in found if math.isinf(weight))
    return [text for _, text in found[: new + MOST_CHANGED]]


def next_command(ladder: KeptLadder, folder: Path) -> tuple[str | Path, ...]:
    """Choose the command that comes next: without what is of no use, else on until the floor is reached."""
    if f"--remove {ladder.top.added}" in ladder.stopped_because:
        return ("refine", folder, "--remove", ladder.top.added)
    on = ladder.verdict is None and not ladder.top.at_floor
    return ("refine", folder, "--auto") if on else ("report", folder)
