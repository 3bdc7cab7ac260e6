"""`station table`: print the paper's tables for any number of sessions."""

import click

from station.commands.options import SESSIONS, declared, option
from station.exits import UsageProblem
from station.output import asked_for_json, next_line, progress
from station.settings import Settings
from station.text.content import Told

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
    from station.text.layout import answer

    opened = [open_session(name, settings.sessions) for name in sessions]
    found, left_out = of_each(opened, lambda session: identified(session, settings))
    for reason in by_reason(left_out):
        progress(f"left out: {reason}")
    if not found:
        raise NotIdentifiable("none of the sessions could be identified")
    if len({result.decay.unit for _, result in found}) > 1:
        raise UsageProblem("some sessions are in m and some in rad: make one table of each")
    if len({result.decay.mass is None for _, result in found}) > 1:
        raise UsageProblem(
            "some sessions have a mass and some have none: K has no common unit; give --mass on import"
        )
    results = [(session.folder.name, result) for session, result in found]
    tables = table.make_tables(results, plain=asked_for_json())
    document = {"table_1": tables.table_1, "table_2": tables.table_2}
    step = ("diagnose" if len(found) > 1 else "compare", *(session.folder for session, _ in found))
    if form == "latex" and not asked_for_json():
        click.echo(table.as_latex(tables), nl=False)
        progress(next_line(*step))  # the table goes into a file
    else:
        answer(document, Told("", "", tuple(table.in_pieces(tables))), *step)
