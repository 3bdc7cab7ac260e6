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
    low: tuple[int, int, int]
    middle: tuple[int, int, int]
    high: tuple[int, int, int]


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
    low=(0, 90, 160),
    middle=(247, 247, 247),
    high=(200, 80, 0),
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
    low=(86, 180, 233),
    middle=(34, 40, 49),
    high=(240, 144, 60),
)


def theme(dark: bool) -> Theme:
    """Return the colours of one of the two."""
    return DARK if dark else LIGHT


def diverging(value: float | None, reach: float, colours: Theme) -> str:
    """Return the colour of a signed value on a scale from -reach to reach; the paper's where there is none."""
    if value is None:
        return "none"
    share = max(-1.0, min(1.0, value / reach)) if reach > 0 else 0.0
    end = colours.high if share > 0 else colours.low
    parts = (round(m + abs(share) * (e - m)) for m, e in zip(colours.middle, end, strict=True))
    return "#" + "".join(f"{part:02x}" for part in parts)
