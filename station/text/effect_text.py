"""Effects in words."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from identify.effects.effect import Effect, Parameter
from identify.formatting import plain_name
from station.text.content import Table, Told, facts
from station.text.numbers import typeset

KINDS = {"physics": "Physics: forces per unit mass", "sensor": "Sensors: faults of a reading"}


def all_told(effects: Sequence[Effect]) -> Told:
    """Tell every effect with its equation, physics first."""
    tables = []
    for kind, title in KINDS.items():
        rows = [(e.name, typeset(f"{e.title}: {e.equation}")) for e in effects if e.kind == kind]
        tables.append(Table(title, ("", ""), tuple(rows), texts=2))
    return Told("", "", tuple(tables))


def told(effect: Effect) -> Told:
    """Tell one effect: what it is, its parameters, how it shows, and what confirms it."""
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
    return Told(plain_name(effect.name), "", (), facts((label, typeset(text)) for label, text in rows))


def bounds(parameter: Parameter) -> str:
    """Write the bounds that physics sets to a parameter."""
    low, high = parameter.low, parameter.high
    if np.isfinite(low) and np.isfinite(high):
        return f"from {low:g} to {high:g}"
    if np.isfinite(low):
        return f"at least {low:g}"
    return f"at most {high:g}" if np.isfinite(high) else "of either sign"


def as_document(effect: Effect) -> dict[str, Any]:
    """Return an effect as a plain document."""
    bounded = ("name", "unit", "meaning", "low", "high")
    return {
        **{key: getattr(effect, key) for key in ("name", "title", "kind", "equation")},
        "parameters": [{key: getattr(p, key) for key in bounded} for p in effect.parameters],
        "borrows": list(getattr(effect, "shared_parameters", ())),
        "tell": effect.symptom,
        "proof": effect.confirming_test,
        "confusable_with": list(effect.confusable_with),
    }
