"""The tasks of a worker other than the ladder and the import: export, report, viewer, examples."""

from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

import numpy as np

from daq.exporting import Exported, encode
from daq.recording import Array, Channel, Recording
from daq.session import Session
from identify.fitting.fit import Fit
from identify.formatting import SPACE, quantity
from station.operations import examples
from station.operations.exporting import facts_of
from station.operations.identifying import identify_session
from station.operations.refining import Refinement
from station.operations.viewer_tabs import write_view
from station.operations.workers import Say
from station.report.write import write_report
from station.settings import Settings
from station.views.viewer import unpack
from station.workbench.opened_session import open_session
from station.workbench.parts import part


def export(settings: Settings, say: Say, folder: Path) -> str:
    """Write the aligned channels, the present model and the residuals as CSV."""
    say("writing the samples")
    opened = open_session(settings, folder)
    return encode(fitted_samples(opened.refinement, opened.present_fit()), "csv").decode()


def fitted_samples(refinement: Refinement, fit: Fit) -> Exported:
    """Gather the samples of the fit, SI: the motion, and of each channel the reading, the model and the residual.

    The motion is on one clock (the lag corrected). Readings that did not count are not a number. The facts have the values
    of the model as they are `stated` everywhere, and the release's own: where it starts, and how its sensors are off.
    """
    window, motion, stated = fit.windows[0], refinement.prepared.motion, refinement.ladder.top.model
    units = {
        "displacement": window.unit,
        "velocity": f"{window.unit}/s",
        "acceleration": f"{window.unit}/s^2",
    }
    columns: list[tuple[str, str, Array]] = [("time since release", "s", np.asarray(window.clock))]
    columns += [(f"{name} aligned", unit, np.asarray(getattr(motion, name))) for name, unit in units.items()]
    for channel in window.channels:
        read = np.where(window.used[channel], window.readings[channel], np.nan)
        model = fit.predicted[0][channel]
        for what, values in (("read", read), ("model", model), ("residual", read - model)):
            columns.append((f"{channel} {what}", units[channel], values))
    recording = Recording(
        window.rate,
        tuple(Channel(name, "other", unit) for name, unit, _ in columns),
        np.array([values for *_, values in columns]),
        np.ones(len(window), dtype=bool),
        rate_std=window.rate_std,
    )
    facts = {"model": " + ".join(stated.names)}
    for entry in stated.effects:
        known = refinement.weighing.weighed(entry.effect, entry.parameters)
        facts |= {f"fitted {entry.effect}.{name}": quantity(value) for name, value in known.items()}
    for name, own in fit.nuisances.items():
        start = name in ("displacement", "velocity") or ".state" in name
        facts[f"{'at the start,' if start else 'fitted'} {name}"] = quantity(replace(own, std=0.0))
    facts = {name: text.replace(SPACE, " ") for name, text in facts.items()}
    return Exported(recording, facts_of(refinement.session) | facts)


def open_example(settings: Settings, say: Say, name: str) -> str:
    """Import a recording that comes with the station, unless it is there already; return its session's name."""
    return examples.open_example(name, settings.sessions).folder.name


def viewer(settings: Settings, say: Say, folder: Path, temporary: Path, host: str, dark: bool) -> str:
    """Write the recording that `station view` writes, and the viewer's own files; return the viewer as HTML."""
    session = Session.open(folder)
    result, _ = identify_session(session, settings, say)
    say("writing the recording")
    file = write_view(session, result, settings, dark=dark)
    if not (temporary / "index.html").is_file():
        unpack(temporary)
    place = f"viewer/recording/{file.stat().st_mtime_ns}/{quote(folder.name, safe='')}.rrd"  # no browser keeps an old one
    recording, theme = quote(f"http://{host}/{place}", safe=""), "dark" if dark else "light"
    return part("viewer", f"/viewer/index.html?url={recording}&hide_welcome_screen=1&theme={theme}")


def report(settings: Settings, say: Say, folder: Path) -> str:
    """Write the report of a session; return the way to it as HTML."""
    say("writing the report")
    write_report(Session.open(folder), settings=settings, progress=say)
    return way_to_report(folder.name)


def way_to_report(key: str) -> str:
    """Write the way to the report of a session as HTML."""
    return part("report", f"/report/{quote(key, safe='')}")
