"""A session's channels on one clock, or its fitted model, in a file of another program's format."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from daq.exporting import Exported, encode
from daq.recording import Array, Channel, Recording
from daq.session import Session
from daq.storage import write_whole
from identify.errors import NotIdentifiable
from identify.fitting.fit import Fit
from identify.formatting import SPACE, quantity
from identify.preprocessing.alignment import correct
from station.exits import UsageProblem
from station.operations.refining import Refinement
from station.settings import Settings
from station.story.preparation import locate, options_for


def exported_session(session: Session, settings: Settings, *, aligned: bool = True) -> Exported:
    """Gather what goes into the file; its fact `channels` says on which clock the channels are.

    With `aligned` the displacement (or velocity) is moved earlier by its lag behind the acceleration, where a lag can
    be estimated; values are not rescaled otherwise.
    """
    recording = session.recording()
    facts, found = facts_of(session) | {"channels": "as recorded"}, None
    try:
        found = locate(recording, options_for(session, settings)) if aligned else None
    except NotIdentifiable as refusal:
        facts["channels"] += f", for they could not be aligned: {refusal}"
    if found is None:
        return Exported(recording, facts)
    facts["release_s"] = f"{found.release.time_s:.6g}"
    if found.alignment is None:
        return Exported(recording, facts | {"channels": f"as recorded: {found.not_aligned}"})
    moved, lag = correct(found.recorded, found.alignment), found.alignment.lag
    name = next(iter(moved.channels))  # the lowest derivative
    samples = np.array(recording.samples)
    samples[[channel.quantity for channel in recording.channels].index(name)] = moved.channels[name]
    valid = recording.valid if moved.valid is None else recording.valid & moved.valid
    facts |= {
        "channels": f"{name} moved earlier by its lag behind the acceleration",
        "lag_s": f"{lag.value:.9g}",
        "lag_std_s": f"{lag.std:.3g}",
        "gain_of_the_acceleration": f"{found.alignment.gain.value:.9g} (estimated, not applied)",
    }
    return Exported(replace(recording, samples=samples, valid=valid), facts)


def fitted_samples(refinement: Refinement, fit: Fit) -> Exported:
    """Gather the samples of the fit, SI: the motion, and of each channel the reading, the model and the residual.

    The motion is on one clock (the lag corrected). Readings that did not count are not a number. The facts have the values
    of the model as they are `stated` everywhere, and the release's own: where it starts, and how its sensors are off.
    """
    window, motion, top = fit.windows[0], refinement.prepared.motion, refinement.ladder.top
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
    facts = {"model": " + ".join(top.effects)}
    facts |= {f"fitted {name}": quantity(value) for name, value in top.weighed(refinement.weighing).items()}
    for name, own in fit.nuisances.items():
        start = name in ("displacement", "velocity") or ".state" in name
        facts[f"{'at the start,' if start else 'fitted'} {name}"] = quantity(replace(own, std=0.0))
    facts = {name: text.replace(SPACE, " ") for name, text in facts.items()}
    return Exported(recording, facts_of(refinement.session) | facts)


def write_exported(exported: Exported, form: str, file: Path, *, overwrite: bool) -> int:
    """Write the file as a whole or not at all and return its size in bytes. Raises UsageProblem where it is there."""
    if file.is_dir() or not file.parent.is_dir():
        where = "is a folder" if file.is_dir() else f"the folder {file.parent} is not there"
        raise UsageProblem(f"{file}: {where}; name a file in a folder that exists")
    if file.exists() and not overwrite:
        raise UsageProblem(f"{file} is there already; choose another name, or --overwrite")
    content = encode(exported, form)
    write_whole(file, content)
    return len(content)


def facts_of(session: Session) -> dict[str, str]:
    """List what a file says of a session, as short texts by name."""
    info = session.info
    board = info.board
    known = {
        "session": session.folder.name,
        "recorded": info.created.isoformat(),
        "operator": info.operator,
        "specimen": info.specimen,
        "remarks": info.remarks,
        "mass_kg": "" if info.mass_kg is None else repr(info.mass_kg),
        "mass_std_kg": "" if info.mass_std_kg is None else repr(info.mass_std_kg),
        "verdict": info.verdict,
        "source": info.source_file or info.source,
        "board": "" if board is None else f"{board.board} {board.firmware} {board.unique_id}".strip(),
        **{f"condition {name}": repr(value) for name, value in info.conditions.items()},
        "written_by": "Free-Decay Station",
    }
    return {name: text for name, text in known.items() if text}
