"""`station export`: write a session's channels for another program."""

from pathlib import Path
from typing import Any

import click

from station.commands.options import SESSION, declared, option
from station.exits import UsageProblem
from station.settings import Settings

FORMATS = ("csv", "mat", "uff", "hdf5", "parquet", "mcap")


@declared("export")
def command(
    settings: Settings,
    session: str = SESSION,
    form: str | None = option(
        "Format (default: by the ending of FILE, else csv).", "--to", type=click.Choice(FORMATS)
    ),
    file: Path | None = option("File to write (default: the session's name with the format's ending, here)."),
    as_recorded: bool = option("Do not move the displacement by its lag."),
    overwrite: bool = option("Replace a file that is there."),
) -> None:
    """Write the channels of SESSION, on one clock, into a file.

    Units, calibration, the lag that was taken out, and where the data come
    from go into the file as far as the format has a place for them. Samples
    that were lost are empty, or not a number.
    """
    from daq.exporting import FORMATS as ENDINGS, form_of
    from station.operations.exporting import exported_session, write_exported
    from station.results.sessions import open_session
    from station.text.content import Table, Told, facts
    from station.text.layout import answer

    if form is None:
        form = "csv" if file is None else form_of(file)
        if form is None:
            raise UsageProblem(f"{file}: the ending tells no format; say --to {', '.join(FORMATS)}")
    opened = open_session(session, settings.sessions)
    target = file if file is not None else Path(f"{opened.folder.name}{ENDINGS[form][0]}")
    exported = exported_session(opened, settings, aligned=not as_recorded)
    size = write_exported(exported, form, target, overwrite=overwrite)
    recording = exported.recording
    document: dict[str, Any] = {
        "file": str(target),
        "format": form,
        "bytes": size,
        "samples": len(recording.valid),
        "rate_hz": recording.rate,
        "channels": {name: channel.unit for name, channel in exported.channels.items()},
        "facts": exported.all_facts,
    }
    columns = ", ".join(f"{name} [{unit}]" for name, unit in document["channels"].items())
    rows = [("columns", f"{columns}: {len(recording.valid)} samples at {recording.rate:g} Hz")]
    rows += [(name, exported.facts.get(name, "")) for name in ("channels", "lag_s", "lag_std_s")]
    written = Table("", ("",), ((f"written: {target} ({form}, {size / 1000:.0f} kB)",),), texts=1)
    answer(document, Told("", "", (written, *facts(rows))))
