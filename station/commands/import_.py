"""`station import`: turn a file of another board into sessions."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from station.commands.options import (
    COLUMNS,
    CONDITIONS,
    MASS,
    MASS_STD,
    OPERATOR,
    POSITIVE,
    SPECIMEN,
    UNITS,
    VARIES,
    argument,
    declared,
    new_session_option,
    option,
)
from station.exits import UsageProblem
from station.output import asked_for_json
from station.settings import Settings
from station.text.content import Told, facts

if TYPE_CHECKING:
    from station.results.sessions import Imported


COUNT = click.IntRange(min=0)

READING = {
    "rate": (float, option("Sampling rate, where the file has no time.", type=POSITIVE, metavar="HZ")),
    "delimiter": (str, option("Between columns: a character, tab or blank.", metavar="SIGN")),
    "decimal": (str, option("Decimal sign.", type=click.Choice([".", ","]))),
    "encoding": (str, option("Text encoding.")),
    "skip_rows": (int, option("Lines to ignore at the top.", type=COUNT, default=0, metavar="N")),
    "resample": (bool, option("Put uneven time stamps on an even clock.")),
    "keep_derived": (bool, option("Keep channels that were computed from another one.")),
    "run": (str, option("One run of a file that holds several (default: all, a session each).", metavar="N")),
    "start": (float, option("Leave out what is before this time of the file.", "--from", metavar="S")),
    "stop": (float, option("Leave out what is after this time of the file.", "--to", metavar="S")),
    "accept": (bool, option("Take the recipe that is proposed where the file does not say all.")),
    "keep_offset": (bool, option("Leave gravity in an acceleration.")),
}
"""How the file is read, for `declared`: the fields of ImportOptions."""


@declared("import", READING)
def command(
    settings: Settings,
    /,
    file: Path = argument(),
    folder: Path | None = new_session_option("Folder of the new session (default: ./sessions/NAME)."),
    mass: float | None = MASS,
    mass_std: float | None = MASS_STD,
    columns: dict[str, str | int] = COLUMNS,
    units: dict[str, str] = UNITS,
    angle_from: str | None = option(
        "Angle of a pendulum from the columns x and y (up) of its bob, from the pivot.", metavar="X,Y"
    ),
    recipe: str | None = option(
        "Read by this recipe alone; none: by no recipe that was kept.", metavar="FILE"
    ),
    ask: bool = option("Open the proposed recipe in your editor."),
    specimen: str | None = SPECIMEN,
    operator: str | None = OPERATOR,
    conditions: tuple[str, ...] = CONDITIONS,
    varies: tuple[str, ...] = VARIES,
    **others: Any,
) -> None:
    """Turn FILE (CSV, JSON, MATLAB .mat, UFF58) into sessions, one for each release.

    Prints what was understood and what was guessed; nothing is overwritten.
    """
    from daq.importing.errors import ImportProblem
    from daq.importing.options import ImportOptions
    from daq.importing.recipe import read_recipe, to_toml
    from station.operations.new_session import session_info
    from station.output import TYPED
    from station.results.kept_recipes import NONE, asked
    from station.results.sessions import explained, import_file
    from station.safe_text import harmless
    from station.text.layout import answer

    options = ImportOptions(
        columns=columns, units=units, angle_from=_two("--angle-from", angle_from), **others
    )
    alone = replace(options, accept=False) == ImportOptions()
    if recipe not in (None, NONE) and (ask or not alone):
        raise UsageProblem(
            f"--recipe {recipe} says how the whole file is read: write the choice there, or leave the option out"
        )
    info = session_info(settings, mass, mass_std, specimen, operator, conditions, varies)
    try:
        given = None if recipe in (None, NONE) else read_recipe(Path(recipe or ""))
        if ask:
            given = asked(file, options, None if recipe == NONE else settings.sessions)
        imported = import_file(file, folder, settings.sessions, options, info, given, anew=recipe == NONE)
    except ImportProblem as refusal:
        if not asked_for_json() and (proposed := getattr(refusal, "proposal", None)) is not None:
            click.echo(harmless(to_toml(proposed.recipe)))
        raise explained(refusal, click.get_current_context().meta[TYPED]) from refusal
    step = ("identify", imported.sessions[0].folder) if imported.released else ()
    answer(_document(file, imported), _told(file, imported), *step)


def _two(option: str, given: str | None) -> tuple[str, str] | None:
    if given is None:
        return None
    x, separator, y = (part.strip() for part in given.partition(","))
    if not separator or not x or not y:
        raise UsageProblem(f"{option} {given}: write two columns, as x,y or 2,3")
    return x, y


def _document(file: Path, imported: "Imported") -> dict[str, Any]:
    from station.results.documents import picked

    recording = imported.recordings[0]
    return {
        "file": str(file),
        "sessions": [str(session.folder) for session in imported.sessions],
        "runs": [recording.run for recording in imported.recordings],
        "rate_hz": recording.rate,
        "samples": sum(int(one.samples.shape[1]) for one in imported.recordings),
        "lost_samples": sum(int((~one.valid).sum()) for one in imported.recordings),
        "channels": [picked(channel, "name", "quantity", "unit") for channel in recording.channels],
        "notes": list(imported.notes),
        "verdicts": [None if one.verdict is None else one.verdict.grade.value for one in imported.sessions],
    }


def _told(file: Path, imported: "Imported") -> Told:
    from daq.quality import Grade
    from daq.session_reading import RECIPE
    from station.text.identification_text import sampling

    rows = []
    for recording in imported.recordings:
        size = sampling(recording.samples.shape[1], recording.rate, recording.rate_std)
        rows.append(("record", f"run {recording.run}: {size}" if recording.run else size))
    rows.append(("channels", ", ".join(f"{c.quantity} [{c.unit}]" for c in imported.recordings[0].channels)))
    rows += [("", note) for note in imported.notes]
    for session in imported.sessions:
        rows.append(("session", str(session.folder)))
        if session.verdict is not None and session.verdict.grade is not Grade.OK:
            rows.append(("verdict", session.verdict.words))
    rows.append(
        ("recipe", f"{imported.sessions[0].folder / RECIPE} (a copy, corrected, is read by --recipe)")
    )
    return Told(file.name, "", facts(rows))
