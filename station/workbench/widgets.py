"""Small parts that every panel is made of."""

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

CLICKED = """(event) => { const at = event.target.closest("[data-do]");
  if (at && at.role === "switch") event.preventDefault();  // it turns when the model has changed
  if (at) emit(at.dataset.do, at.dataset.to || "") }"""


def card(classes: str = "") -> ui.element:
    """Make a box; used as a context."""
    return ui.element("section").classes(f"card {classes}")


def line(classes: str = "") -> ui.element:
    """Make a row of things side by side; used as a context."""
    return ui.element("div").classes(f"line {classes}")


def head(text: str) -> None:
    """Show a heading."""
    with ui.element("h2").classes("head"):
        label(text)


def label(text: str, classes: str = "") -> ui.label:
    """Show text; it is escaped, whatever is in it."""
    return ui.label(text).classes(classes)


def html(classes: str = "", does: Mapping[str, Callable[[str], Any]] | None = None) -> ui.html:
    """Make a place for what `parts.part` writes; `does` are the actions of its elements, each called with its `data-to`."""
    made = ui.html("", sanitize=False).classes(classes)
    if does is not None:
        made.on("click", lambda e: does[e.args[0]](e.args[1]), js_handler=CLICKED)
    return made


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


def number(label: str, value: float | None = None) -> ui.number:
    """Make a field for a number that is not negative."""
    made = ui.number(label, value=value, min=0, format="%g").props("dense outlined")
    made.props["aria-label"] = label
    return made


def chart(name: str, label: str, classes: str) -> None:
    """Show a chart, which the page's script draws under its `name`."""
    made = ui.echart({}).classes(f"plot {classes}")
    made.props.update({"data-plot": name, "tabindex": "0", "role": "img", "aria-label": label})


async def is_dark() -> bool:
    """Ask the tab whether it shows dark colours; one that was closed meanwhile does not."""
    try:
        return bool(await ui.run_javascript("bench.dark()", timeout=20.0))
    except TimeoutError:
        return False
