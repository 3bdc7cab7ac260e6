"""What a worker does beside the ladder: export, revealing, previewing."""

from pathlib import Path

from daq.exporting import encode
from daq.session import Session
from identify.fitting.fit import Fit
from station.results.ladder import read_ladder
from station.results.models import name_of
from station.settings import Settings
from station.story.pipeline import Progress
from station.workbench import view_models
from station.workbench.export import fitted_samples
from station.workbench.frame_store import of_step
from station.workbench.frames import frame_id
from station.workbench.opened_session import Opened, open_session
from station.workbench.unkept import frame_of_tried


def export(settings: Settings, progress: Progress, folder: Path) -> str:
    """Return the aligned channels, the present model and the residuals as CSV."""
    progress("writing the samples")
    opened = open_session(settings, folder)
    refinement = opened.refinement
    exported = fitted_samples(refinement.session, refinement.prepared, _present_fit(opened))
    return encode(exported, "csv").decode()


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
