"""What a worker does beside the ladder: export, revealing, previewing."""

from pathlib import Path

import numpy as np

from daq.exporting import Exported, encode
from daq.recording import Array, Channel, Recording
from daq.session import Session
from identify.fitting.fit import Fit
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.exporting import facts_of
from station.results.ladder import read_ladder
from station.results.models import name_of
from station.settings import Settings
from station.story.pipeline import Progress
from station.workbench import view_models
from station.workbench.frame_store import frame_of_tried, of_step
from station.workbench.frames import frame_id
from station.workbench.opened_session import Opened, open_session


def export(settings: Settings, progress: Progress, folder: Path) -> str:
    """Return the aligned channels, the present model and the residuals as CSV."""
    progress("writing the samples")
    opened = open_session(settings, folder)
    refinement = opened.refinement
    exported = fitted_samples(refinement.session, refinement.prepared, _present_fit(opened))
    return encode(exported, "csv").decode()


def fitted_samples(session: Session, prepared: PreparedDecay, fit: Fit) -> Exported:
    """Return the samples of the fit, SI: the motion, and of each channel the reading, the model and the residual.

    The motion is on one clock (the lag corrected). Readings that did not count are not a number.
    """
    window, motion = fit.windows[0], prepared.motion
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
    facts = {"model": " + ".join(term.effect.name for term in fit.model.terms)}
    facts |= {f"fitted {name}": f"{found.value:.9g} ± {found.std:.3g}" for name, found in fit.values.items()}
    return Exported(recording, facts_of(session) | facts)


def reveal(settings: Settings, progress: Progress, folder: Path) -> str:
    """Say what the board of a mystery hid, and whether the present model has it."""
    from station.operations.mystery import hidden_words, what_was_hidden

    session = Session.open(folder)
    truth = what_was_hidden(session)
    ladder = read_ladder(session)
    found = ladder is not None and truth["hidden"] in ladder.top.effects
    values = ", ".join(
        f"{name} {value:.4g}" for name, value in truth["parameters"].get(truth["hidden"], {}).items()
    )
    words = f"The simulated board hid {hidden_words(truth)}{f' ({values})' if values else ''}."
    return f"{words} {'It is in your model: solved.' if found else 'It is not in your model yet.'}"


def _present_fit(opened: Opened) -> Fit:
    top = opened.refinement.ladder.top
    of_step(opened.store, opened.refinement, top)
    return opened.store.fits[frame_id(top.model)]


def preview(settings: Settings, progress: Progress, folder: Path, wanted: str) -> view_models.Frame:
    """Return the frame of the present model with an expression of the user's own; nothing is kept."""
    opened = open_session(settings, folder)
    _present_fit(opened)
    return frame_of_tried(opened.store, opened.refinement, wanted, name_of(wanted))[1]
