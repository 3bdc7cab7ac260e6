"""The Curves tab: frequency and damping of every release against amplitude, the laws of the models laid over."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from station.results.curves import NamedCurves
from station.text.curves_text import curves_caption
from station.views import log
from station.views.curve_panels import draw_panels
from station.views.figure import figure
from station.views.plots import SCREEN

ROOT = "/curves"
NAME = "Curves"


def write(stream: rr.RecordingStream, shown: NamedCurves, root: str = ROOT) -> None:
    """Log the picture with the numbers that it shows, and what they mean."""
    drawn, axes = figure(13.0, 6.4, 1, 2)
    found = shown.curves
    draw_panels(axes, found, shown.names, SCREEN)
    numbers: dict[str, log.Array] = {}
    for curve in found.releases:
        numbers |= {
            f"{what}_{curve.release}": getattr(curve, what)
            for what in ("amplitude", "frequency", "frequency_std", "damping", "damping_std")
        }
    for place, laid in enumerate(found.laws):
        for what in ("amplitude", "frequency", "damping"):
            parts = [getattr(curve, what) for curve in laid.curves]
            numbers[f"law_{place}_{what}"] = np.concatenate(parts) if parts else np.zeros(0)
    log.picture(stream, f"{root}/panels", drawn, numbers)
    log.markdown(stream, f"{root}/meaning", f"# Curves\n\n{curves_caption(shown.names, found)}")


def tab(root: str = ROOT) -> rrb.Container:
    """Return the layout of the tab."""
    return rrb.Horizontal(
        log.document("Meaning", f"{root}/meaning"),
        log.shown_picture("Frequency and damping against amplitude", f"{root}/panels"),
        column_shares=[1, 4],
        name=NAME,
    )
