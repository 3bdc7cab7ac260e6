"""Colours of the page, light and dark; distinct for colour-blind eyes (after Okabe and Ito)."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Theme:
    """One colour for one thing, in every picture."""

    ink: str
    faint: str
    grid: str
    paper: str
    measured: str
    model: str
    left: str
    noise: str
    floor: str
    other: str


LIGHT = Theme(
    ink="#1d2530",
    faint="#5c6774",
    grid="#e3e7ec",
    paper="#ffffff",
    measured="#1d2530",
    model="#d55e00",
    left="#0072b2",
    noise="rgba(0,158,115,0.22)",
    floor="#00795a",
    other="#a0527f",
)
DARK = Theme(
    ink="#e4e8ee",
    faint="#9aa5b2",
    grid="#2b333e",
    paper="#171c23",
    measured="#e4e8ee",
    model="#f0903c",
    left="#56b4e9",
    noise="rgba(60,200,150,0.25)",
    floor="#3cc896",
    other="#e08cc0",
)


def theme(dark: bool) -> Theme:
    """Return the colours of one of the two."""
    return DARK if dark else LIGHT
