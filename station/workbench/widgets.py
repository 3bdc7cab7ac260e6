"""Small parts that every panel is made of."""

from collections.abc import Callable
from typing import Any

from nicegui import ui

from station.workbench.view_models import Numbers

WIDTH, HEIGHT = 84, 26
"""Of a sparkline, pixels."""


def card(classes: str = "") -> ui.element:
    """Return a box; used as a context."""
    return ui.element("section").classes(f"card {classes}")


def line(classes: str = "") -> ui.element:
    """Return a row of things side by side; used as a context."""
    return ui.element("div").classes(f"line {classes}")


def head(text: str) -> None:
    """Show a heading."""
    with ui.element("h2").classes("head"):
        label(text)


def label(text: str, classes: str = "") -> ui.label:
    """Show text; it is escaped, whatever is in it."""
    return ui.label(text).classes(classes)


def spinner(size: int = 18) -> ui.element:
    """Show that something runs; it turns by the compositor, so that a computation beside it loses nothing."""
    return (
        ui.element("span")
        .classes("turning")
        .style(f"width:{size}px; height:{size}px")
        .props("aria-hidden=true")
    )


def button(
    text: str, does: Callable[[], Any], name: str = "", strong: bool = False, classes: str = ""
) -> ui.button:
    """Show a button; `name` says to those who do not see it what it does, where its text alone does not."""
    made = ui.button(text, on_click=lambda: does(), color=None).classes(classes)
    made.props("dense no-caps padding='3px 11px'" + (" unelevated" if strong else " outline"))
    if strong:
        made.style("background: var(--accent); color: var(--accent-ink)")
    if name:
        made.props["aria-label"] = name
    return made


def sparkline(line: Numbers) -> ui.html:
    """Show the outline of a decay, -1 to 1; an empty box without points. Made of numbers only."""
    steps = max(len(line) - 1, 1)
    points = " ".join(
        f"{WIDTH * i / steps:.1f},{HEIGHT / 2 * (1 - 0.92 * value):.1f}"
        for i, value in enumerate(line)
        if value is not None
    )
    return ui.html(
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" aria-hidden="true">'
        f'<polyline points="{points}" fill="none" stroke="currentColor" stroke-width="1"/></svg>',
        sanitize=False,
    )


def chart(name: str, label: str, classes: str) -> None:
    """Show a chart, which the page's script draws under its `name`."""
    made = ui.echart({}).classes(f"plot {classes}")
    made.props["data-plot"] = name
    made.props["tabindex"] = "0"
    made.props["role"] = "img"
    made.props["aria-label"] = label


def run(script: str) -> None:
    """Run a script in the tab, without waiting for it."""
    ui.run_javascript(script)
