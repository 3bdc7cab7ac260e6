"""The tasks of a worker other than the ladder: import, export, report, viewer, revealing."""

from pathlib import Path

import numpy as np

from daq.exporting import Exported, encode
from daq.importing.recipe import Recipe
from daq.recording import Array, Channel, Recording
from daq.session import Session
from identify.fitting.fit import Fit
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.exporting import facts_of
from station.results.ladder import read_ladder
from station.settings import Settings
from station.workbench.opened_session import open_session
from station.workbench.session_thumbnails import outline
from station.workbench.view_models import AskedColumn, ImportQuestion
from station.workbench.worker import Say


def export(settings: Settings, say: Say, folder: Path) -> str:
    """Write the aligned channels, the present model and the residuals as CSV."""
    say("writing the samples")
    opened = open_session(settings, folder)
    refinement = opened.refinement
    exported = fitted_samples(refinement.session, refinement.prepared, opened.present_fit())
    return encode(exported, "csv").decode()


def fitted_samples(session: Session, prepared: PreparedDecay, fit: Fit) -> Exported:
    """Gather the samples of the fit, SI: the motion, and of each channel the reading, the model and the residual.

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


def reveal(settings: Settings, say: Say, folder: Path) -> str:
    """Say what the board of a mystery hid, and whether the present model has it."""
    from station.operations.mystery import hidden_words, what_was_hidden

    session = Session.open(folder)
    truth, ladder = what_was_hidden(session), read_ladder(session)
    hidden = truth["hidden"]
    values = ", ".join(f"{name} {value:.4g}" for name, value in truth["parameters"].get(hidden, {}).items())
    words = f"The simulated board hid {hidden_words(truth)}{f' ({values})' if values else ''}."
    found = ladder is not None and hidden in ladder.top.effects
    return f"{words} {'It is in your model: solved.' if found else 'It is not in your model yet.'}"


def import_file(
    settings: Settings, say: Say, file: Path, recipe: Recipe | None, ask: bool, mass: float | None
) -> tuple[list[str], list[str]] | ImportQuestion:
    """Import a data file; return the names of the sessions and what was understood, or what is to be said first."""
    from daq.importing.options import ImportOptions
    from daq.importing.propose import Doubtful
    from station.operations.new_session import session_info
    from station.results.kept_recipes import look_with_kept
    from station.results.sessions import import_file as make

    say(f"reading {file.name}")
    info = session_info(settings, mass)
    try:
        if ask:
            known = look_with_kept(file, settings.sessions)[0].read().recipe
            return _question(file, known, f"{file.name}: what the columns seem to be")
        imported = make(file, None, settings.sessions, ImportOptions(), info, recipe)
    except Doubtful as refusal:
        doubts = (doubt.partition("; ")[0] for doubt in refusal.proposal.doubts)  # what to do is on the page
        return _question(file, refusal.proposal.recipe, f"{file.name}: {'; '.join(doubts)}")
    return [session.folder.name for session in imported.sessions], list(imported.notes)


def _question(file: Path, recipe: Recipe, sentence: str) -> ImportQuestion:
    from daq.importing.apply import matched
    from daq.importing.reading import read_table

    table = read_table(file, recipe)
    found = {id(field): number for number, field in matched(table, recipe).items()}
    columns = {column.number: column for column in table.columns}
    asked = []
    for field in recipe.fields:
        column = columns[found[id(field)]]
        first = ", ".join(f"{value:.5g}" for value in column.values[:4])
        asked.append(AskedColumn(column.place, first, outline(column.values)[1]))
    return ImportQuestion(sentence, recipe, tuple(asked))


def open_example(settings: Settings, say: Say, name: str) -> str:
    """Import a recording that comes with the station, unless it is there already; return its session's name."""
    from station.operations import examples

    return examples.open_example(name, settings.sessions).folder.name


def viewer(settings: Settings, say: Say, folder: Path, temporary: Path, dark: bool) -> int:
    """Write the recording that `station view` writes, and the viewer's own files; return the recording's age (ns)."""
    from station.operations.identifying import identify_session, kept_options, write_view
    from station.operations.viewer_tabs import kept_tabs
    from station.views import web_viewer

    session = Session.open(folder)
    say("identifying")
    result, _ = identify_session(session, kept_options(session, settings))
    say("writing the recording")
    file = write_view(session, result, kept_tabs(session, settings), dark=dark)
    if not (temporary / web_viewer.FILES[0]).is_file():
        web_viewer.unpack(temporary)
    return file.stat().st_mtime_ns


def report(settings: Settings, say: Say, folder: Path) -> None:
    """Write the report of a session."""
    from station.report.write import write_report

    say("writing the report")
    write_report(Session.open(folder), settings=settings, progress=say)
