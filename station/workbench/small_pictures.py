"""Small pictures as SVG: a decay as a sparkline, a map of force as a disc. Made of numbers only."""

import math

from station.workbench import view_models
from station.workbench.theme import Theme, diverging

WIDTH, HEIGHT = 84, 26
DISC = 64


def sparkline(line: view_models.Numbers) -> str:
    """Return the outline of a decay; an empty box without points."""
    steps = max(len(line) - 1, 1)
    points = " ".join(
        f"{WIDTH * i / steps:.1f},{HEIGHT / 2 * (1 - 0.92 * value):.1f}"
        for i, value in enumerate(line)
        if value is not None
    )
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" aria-hidden="true">'
        f'<polyline points="{points}" fill="none" stroke="currentColor" stroke-width="1"/></svg>'
    )


def disc(found: view_models.ForceMap, reach: float, colours: Theme) -> str:
    """Return a map of force: displacement to the right, velocity upwards, force as colour from -reach to reach."""
    half = DISC / 2
    radii = [half * 0.97 * (edge or 0.0) for edge in found.amplitude]
    parts = []
    for ring, row in enumerate(found.force):
        for sector, force in enumerate(row):
            if force is None:
                continue
            first, second = found.phase[sector] or 0.0, found.phase[sector + 1] or 0.0
            path = _wedge(half, radii[ring], radii[ring + 1], first, second)
            parts.append(f'<path d="{path}" fill="{diverging(force, reach, colours)}"/>')
    return (
        f'<svg viewBox="0 0 {DISC} {DISC}" width="{DISC}" height="{DISC}" aria-hidden="true">'
        f'<circle cx="{half}" cy="{half}" r="{half * 0.97}" fill="none" stroke="{colours.grid}"/>{"".join(parts)}</svg>'
    )


def _wedge(half: float, inner: float, outer: float, first: float, second: float) -> str:
    """Return the outline of a bin; the phase grows with time, from the right downwards (v = -A w sin)."""

    def point(radius: float, phase: float) -> str:
        return f"{half + radius * math.cos(phase):.1f} {half + radius * math.sin(phase):.1f}"

    return f"M{point(inner, first)}L{point(outer, first)}L{point(outer, second)}L{point(inner, second)}Z"


def reach_of(force_maps: dict[str, view_models.ForceMap]) -> float:
    """Return the force that is drawn in full colour: the 98th percentile of what the model lacks."""
    residual = force_maps.get("")
    sizes = sorted(abs(f) for row in residual.force for f in row if f is not None) if residual else []
    return sizes[int(0.98 * (len(sizes) - 1))] if sizes else 1.0
