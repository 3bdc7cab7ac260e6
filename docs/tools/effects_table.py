"""The table of all effects, made of the library itself."""

PLACE = "<!-- table of effects -->"


def with_effects(text: str) -> str:
    """Put the table where a page has a place for it; the text as it is without one."""
    return text.replace(PLACE, effects_table()) if PLACE in text else text


def effects_table() -> str:
    """Return every effect of the library as a row in Markdown: name, title, equation, symptom, what looks alike."""
    from identify.effects.library import LIBRARY

    rows = [
        "| name | what it is | equation (per unit mass; a reading, for sensors) | how it shows | looks like |",
        "|---|---|---|---|---|",
    ]
    for effect in LIBRARY:
        equation = effect.equation.replace("|", "\\|")
        alike = ", ".join(effect.confusable_with) or "-"
        rows.append(f"| `{effect.name}` | {effect.title} | `{equation}` | {effect.symptom} | {alike} |")
    return "\n".join(rows)
