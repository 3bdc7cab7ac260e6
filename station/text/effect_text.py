"""Effects in words, and as charts of 80 columns made of letters."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from identify.effects.effect import Effect, Parameter
from identify.effects.force_effect import ForceEffect
from identify.formatting import plain_name
from station.story.effect_portrait import AMPLITUDES, FREQUENCY, Array, Portrait

HEIGHT = 9
WIDTH = 34


def show_list(console: Console, effects: Sequence[Effect]) -> None:
    """Print every effect with its equation, physics first."""
    for kind, title in (
        ("physics", "Physics: forces per unit mass"),
        ("sensor", "Sensors: faults of a reading"),
    ):
        console.print(Text(f"\n {title}", style="bold"))
        table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 1), show_header=False)
        table.add_column(no_wrap=True, style="cyan")
        table.add_column(overflow="fold")
        for effect in effects:
            if effect.kind == kind:
                table.add_row(Text(effect.name), Text(f"{effect.title}: {effect.equation}"))
        console.print(table)
    console.print("\n next: station effects NAME", markup=False)


def show_effect(console: Console, effect: Effect, portrait: Portrait | None) -> None:
    """Print one effect: what it is, its parameters, how it shows, what confirms it, and its charts."""
    console.print(Text(f"\n {plain_name(effect.name)}", style="bold"))
    console.print(_line("name", effect.name))
    console.print(_line("what it is", effect.title))
    console.print(
        _line("equation", f"{effect.equation}" + (" (per unit mass)" if effect.kind == "physics" else ""))
    )
    console.print(
        _line("kind", "a force" if effect.kind == "physics" else "a fault of a sensor, not a force")
    )
    for parameter in effect.parameters:
        console.print(_line(parameter.name, f"{parameter.meaning}, {parameter.unit}, {bounds(parameter)}"))
    for name in _shared(effect):
        console.print(_line("uses", name))
    console.print(_line("shows as", effect.symptom))
    console.print(_line("proof", effect.confirming_test))
    if effect.confusable_with:
        console.print(_line("confusable", ", ".join(effect.confusable_with)))
    if portrait is None:
        return
    typical = ", ".join(f"{name} {value:.3g}" for name, value in portrait.values.items() if "." not in name)
    length, factor = portrait.length
    size = f"{AMPLITUDES[portrait.unit] * factor:g} {length} at {FREQUENCY / 2 / np.pi:g} Hz"
    note = f"{size}, the largest force 1 % of the springs': {typical}"
    console.print(_line("drawn for", note))
    console.print()
    for line in charts(portrait):
        console.print(f" {line}", markup=False)


def _shared(effect: Effect) -> list[str]:
    """Return the parameters of other effects that a force uses too, by "effect.parameter"."""
    return list(effect.shared_parameters) if isinstance(effect, ForceEffect) else []


def _line(label: str, text: str) -> Table:
    line = Table.grid(padding=(0, 1))
    line.add_column(width=12)
    line.add_column(overflow="fold")
    line.add_row(Text(f" {label}", style="cyan"), Text(text))
    return line


def bounds(parameter: Parameter) -> str:
    """Return what physics allows of a parameter, in words."""
    low, high = parameter.low, parameter.high
    if np.isfinite(low) and np.isfinite(high):
        return f"from {low:g} to {high:g}"
    if np.isfinite(low):
        return f"at least {low:g}"
    return f"at most {high:g}" if np.isfinite(high) else "of either sign"


def charts(portrait: Portrait) -> list[str]:
    """Return force over u and v, and damping and frequency over amplitude, as lines of at most 78 letters."""
    found = portrait.signature
    length, factor = portrait.length
    speed, force = f"{portrait.unit}/s", f"{portrait.unit}/s^2"
    amplitude = found.amplitude * factor
    first = _side_by_side(
        _chart("force over displacement", portrait.displacement * factor, portrait.force, length, force),
        _chart("force over velocity", portrait.velocity, portrait.force, speed, force),
    )
    second = _side_by_side(
        _chart("damping over amplitude", amplitude, found.damping, length, "1/s"),
        _chart("frequency over amplitude", amplitude, 50.0 * found.stiffening / FREQUENCY**2, length, "%"),
    )
    return [*first, "", *second]


def _chart(title: str, x: Array, y: Array, x_unit: str, y_unit: str) -> list[str]:
    low, high = float(np.min(y)), float(np.max(y))
    if high - low < 1e-9 * max(abs(high), abs(low), 1e-9):
        low, high = low - 1.0, high + 1.0
    if abs(high) < 1e-12:
        low, high = min(low, -1e-12), high
    columns = np.clip(
        ((x - x.min()) / max(np.ptp(x), 1e-300) * (WIDTH - 1)).round().astype(int), 0, WIDTH - 1
    )
    rows = np.clip(((high - y) / (high - low) * (HEIGHT - 1)).round().astype(int), 0, HEIGHT - 1)
    canvas = np.full((HEIGHT, WIDTH), " ")
    if low < 0.0 < high:
        canvas[round(high / (high - low) * (HEIGHT - 1))] = "·"
    canvas[rows, columns] = "*"
    top = f"{title} [{y_unit}]"
    lines = [top, f"{high:.3g}"]
    lines += ["|" + "".join(row) for row in canvas]
    left, right = f"{x.min():.3g}", f"{x.max():.3g} {x_unit}"
    return [*lines, f"{low:.3g}", f" {left}{right:>{WIDTH - len(left)}}"]


def _side_by_side(left: list[str], right: list[str]) -> list[str]:
    return [f"{one:<{WIDTH + 5}}{other}".rstrip() for one, other in zip(left, right, strict=True)]


def as_document(effect: Effect, portrait: Portrait | None) -> dict[str, Any]:
    """Return an effect as a plain document."""
    document: dict[str, Any] = {
        "name": effect.name,
        "title": effect.title,
        "kind": effect.kind,
        "equation": effect.equation,
        "parameters": [
            {
                "name": p.name,
                "unit": p.unit,
                "meaning": p.meaning,
                "low": p.low if np.isfinite(p.low) else None,
                "high": p.high if np.isfinite(p.high) else None,
            }
            for p in effect.parameters
        ],
        "borrows": _shared(effect),
        "tell": effect.symptom,
        "proof": effect.confirming_test,
        "confusable_with": list(effect.confusable_with),
    }
    if portrait is not None:
        document["signature"] = {
            "values": portrait.values,
            "frequency_rad_s": FREQUENCY,
            f"amplitude_{portrait.unit}": portrait.signature.amplitude.tolist(),
            "damping_1_s": portrait.signature.damping.tolist(),
            "change_of_w2_1_s2": portrait.signature.stiffening.tolist(),
        }
    return document
