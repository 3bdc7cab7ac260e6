"""`station effects`: list the effects a model may lack, or describe one."""

from math import isfinite
from typing import TYPE_CHECKING, Any

from station.commands.options import argument, declared
from station.text.content import Table, Told, facts

if TYPE_CHECKING:
    from identify.effects.effect import Effect, Parameter

KINDS = {"physics": "Physics: forces per unit mass", "sensor": "Sensors: faults of a reading"}


@declared("effects")
def command(name: str | None = argument(required=False)) -> None:
    """List the effects that may be missing, or describe NAME.

    With NAME: its equation, parameters with units and bounds, how it shows,
    what proves it, and what it is confused with.
    """
    from identify.effects.library import NAMED
    from identify.formatting import plain_name
    from station.own_effects import named_effect
    from station.text.layout import answer
    from station.text.numbers import typeset

    if name is not None:
        effect = named_effect(name)
        rows = facts((label, typeset(text)) for label, text in _rows(effect))
        answer(_document(effect), Told(plain_name(effect.name), "", rows))
        return
    tables = []
    for kind, title in KINDS.items():
        listed = [(e.name, typeset(f"{e.title}: {e.equation}")) for e in NAMED if e.kind == kind]
        tables.append(Table(title, ("", ""), tuple(listed), texts=2))
    answer({"effects": [_document(e) for e in NAMED]}, Told("", "", tuple(tables)), "effects", "NAME")


def _rows(effect: "Effect") -> list[tuple[str, str]]:
    """Tell one effect: what it is, its parameters, how it shows, and what confirms it."""
    physics = effect.kind == "physics"
    return [
        ("name", effect.name),
        ("what it is", f"{effect.title}; {'a force' if physics else 'a fault of a sensor, not a force'}"),
        ("equation", effect.equation + (" (per unit mass)" if physics else "")),
        *((p.name, f"{p.meaning}, {p.unit}, {_bounds(p)}") for p in effect.parameters),
        *(("uses", name) for name in getattr(effect, "shared_parameters", ())),
        ("shows as", effect.symptom),
        ("proof", effect.confirming_test),
        ("confusable", ", ".join(effect.confusable_with)),
    ]


def _bounds(parameter: "Parameter") -> str:
    """Write the bounds that physics sets to a parameter."""
    low, high = parameter.low, parameter.high
    if isfinite(low) and isfinite(high):
        return f"from {low:g} to {high:g}"
    if isfinite(low):
        return f"at least {low:g}"
    return f"at most {high:g}" if isfinite(high) else "of either sign"


def _document(effect: "Effect") -> dict[str, Any]:
    """Return an effect under the keys that other programs rely on."""
    from station.results.documents import picked

    return {
        **picked(effect, "name", "title", "kind", "equation", "confusable_with", tell="symptom"),
        "parameters": [picked(p, "name", "unit", "meaning", "low", "high") for p in effect.parameters],
        "borrows": list(getattr(effect, "shared_parameters", ())),
        "proof": effect.confirming_test,
    }
