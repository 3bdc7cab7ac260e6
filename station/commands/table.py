"""`station table`: the paper's tables for any number of sessions."""

import click

from station.commands.options import SESSIONS, declared, option
from station.exits import UsageProblem
from station.output import asked_for_json, next_line, print_json, progress
from station.settings import Settings

FORMATS = ("text", "latex")


@declared("table")
def command(
    settings: Settings,
    sessions: tuple[str, ...] = SESSIONS,
    form: str = option("", "--format", type=click.Choice(FORMATS), default="text", show_default=True),
) -> None:
    """Print Table 1 (each release) and Table 2 (mean, spread) of SESSIONS.

    Sessions are identified on the way. Angles and lengths do not go into one
    table.
    """
    from identify.errors import NotIdentifiable
    from station.operations.identifying import identified
    from station.operations.session_set import by_reason, of_each
    from station.results.sessions import open_session
    from station.text import table

    opened = [open_session(name, settings.sessions) for name in sessions]
    found, left_out = of_each(opened, lambda session: identified(session, settings))
    for reason in by_reason(left_out):
        progress(f"left out: {reason}")
    documents, folders = [document for _, document in found], [session.folder for session, _ in found]
    if not documents:
        raise NotIdentifiable("none of the sessions could be identified")
    if len({document["record"]["unit"] for document in documents}) > 1:
        raise UsageProblem("some sessions are in m and some in rad: make one table of each")
    if len({document["record"]["mass_kg"] is None for document in documents}) > 1:
        raise UsageProblem(
            "some sessions have a mass and some have none: K has no common unit; give --mass on import"
        )
    tables = table.make_tables(documents, plain=asked_for_json())
    if asked_for_json():
        print_json({"table_1": tables.table_1, "table_2": tables.table_2})
    else:
        click.echo(table.as_text(tables) if form == "text" else table.as_latex(tables), nl=False)
        step = next_line("diagnose" if len(folders) > 1 else "compare", *folders)
        if form == "text":
            click.echo(f"\n{step}")
        else:  # the table goes into a file
            progress(step)
