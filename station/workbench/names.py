"""What effects are called on the page."""

import re

from identify.effects.library import LIBRARY

PEOPLE = {word.lower(): word for effect in LIBRARY for word in re.findall(r"\b[A-Z][a-z]+\b", effect.title)}
"""Names of people in the effects' titles, by their small letters."""


def plain(name: str) -> str:
    """Return an effect's name without underscores, names of people with a capital."""
    return " ".join(PEOPLE.get(word, word) for word in name.split("_"))


def title(name: str) -> str:
    """Return the same as the beginning of a line."""
    words = plain(name)
    return f"{words[:1].upper()}{words[1:]}"
