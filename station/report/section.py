"""A numbered section of the report."""

from dataclasses import dataclass

from station.text.content import Part


@dataclass(frozen=True)
class Section:
    """One section; `name` is its anchor."""

    name: str
    title: str
    parts: tuple[Part, ...]
