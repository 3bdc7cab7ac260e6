"""Small pictures as SVG: a decay as a sparkline. Made of numbers only."""

from station.workbench import view_models

WIDTH, HEIGHT = 84, 26


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
