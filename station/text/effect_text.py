"""Effects in words."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.text import Text

from identify.effects.effect import Effect, Parameter
from identify.formatting import plain_name
from station.story.effect_portrait import AMPLITUDES, FREQUENCY, Array, Portrait
from station.text.content import Table, facts
from station.text.layout import show_parts
from station.text.next_step import next_line
from station.text.numbers import typeset


def show_list(console: Console, effects: Sequence[Effect]) -> None:
    """Print every effect with its equation, physics first."""
    for kind, title in (
        ("physics", "Physics: forces per unit mass"),
        ("sensor", "Sensors: faults of a reading"),
    ):
        rows = [(e.name, typeset(f"{e.title}: {e.equation}")) for e in effects if e.kind == kind]
        show_parts(console, [Table(title, ("", ""), tuple(rows), texts=2)])
    console.print(next_line("effects", "NAME"), markup=False)


def show_effect(console: Console, effect: Effect, portrait: Portrait | None) -> None:
    """Print one effect: what it is, its parameters, how it shows, what confirms it, and what it does."""
    console.print(Text(f" {plain_name(effect.name)}", style="bold"))
    show_parts(console, facts((label, typeset(text)) for label, text in _rows(effect, portrait)))


def _rows(effect: Effect, portrait: Portrait | None) -> list[tuple[str, str]]:
    physics = effect.kind == "physics"
    rows = [
        ("name", effect.name),
        ("what it is", f"{effect.title}; {'a force' if physics else 'a fault of a sensor, not a force'}"),
        ("equation", effect.equation + (" (per unit mass)" if physics else "")),
        *((p.name, f"{p.meaning}, {p.unit}, {bounds(p)}") for p in effect.parameters),
        *(("uses", name) for name in getattr(effect, "shared_parameters", ())),
        ("shows as", effect.symptom),
        ("proof", effect.confirming_test),
        ("confusable", ", ".join(effect.confusable_with)),
    ]
    if portrait is None:
        return rows
    typical = ", ".join(f"{name} {value:.3g}" for name, value in portrait.values.items() if "." not in name)
    length, factor = portrait.length
    size = f"{AMPLITUDES[portrait.unit] * factor:g} {length} at {FREQUENCY / 2 / np.pi:g} Hz"
    found = portrait.signature
    shift = 50.0 * found.stiffening / FREQUENCY**2
    rows.append(("at", f"{size}, the largest force 1 % of the springs': {typical}"))
    rows.append(("damping", f"{_from_to(found.damping)} 1/s from the smallest to that amplitude"))
    rows.append(("frequency", f"changed by {_from_to(shift)} %; --picture FILE draws both"))
    return rows


def _from_to(values: Array) -> str:
    """Write the first and the last of some values; one where they are the same."""
    first, last = (f"{0.0 if abs(value) < 1e-9 else value:.3g}" for value in (values[0], values[-1]))
    return first if first == last else f"{first} to {last}"


def bounds(parameter: Parameter) -> str:
    """Write the bounds that physics sets to a parameter."""
    low, high = parameter.low, parameter.high
    if np.isfinite(low) and np.isfinite(high):
        return f"from {low:g} to {high:g}"
    if np.isfinite(low):
        return f"at least {low:g}"
    return f"at most {high:g}" if np.isfinite(high) else "of either sign"


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
        "borrows": list(getattr(effect, "shared_parameters", ())),
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
