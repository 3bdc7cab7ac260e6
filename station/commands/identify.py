"""`station identify`: find stiffness, friction and damping in a session."""

import click

from station.commands.options import FULL, POSITIVE, SESSION, declared, option
from station.exits import UsageProblem
from station.output import progress
from station.settings import Settings


@declared("identify")
def command(
    settings: Settings,
    session: str = SESSION,
    mass: float | None = option("Mass, instead of the session's.", type=POSITIVE, metavar="KG"),
    max_order: int | None = option("Highest order of damping that is tried.", type=click.IntRange(0, 5)),
    stiffness_orders: str | None = option("Orders of displacement in the restoring force.", metavar="1,3"),
    full: bool = FULL,
) -> None:
    """Find stiffness, friction and damping in SESSION.

    SESSION is a session's folder or name, or a data file, which is imported
    first. Without a mass the values are per unit mass, and the units say so.
    """
    from dataclasses import replace

    from station.operations.identifying import identify_session, refuse_if_nothing
    from station.operations.new_session import session_info
    from station.results.sessions import open_session
    from station.story.preparation import options_for
    from station.text.identification_text import next_command, told
    from station.text.layout import answer

    opened = open_session(session, settings.sessions, session_info(settings, mass))
    options = options_for(opened, settings, mass)
    if max_order is not None:
        options = replace(options, max_order=max_order)
    if stiffness_orders is not None:
        options = replace(options, stiffness_orders=_orders(stiffness_orders))
    result, document = identify_session(opened, settings, progress, options)
    words = told(opened.folder.name, result, full=full)
    answer(document, words, next_command(result), opened.folder)
    refuse_if_nothing(result)


def _orders(text: str) -> tuple[int, ...]:
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isdigit() and 1 <= int(part) <= 9 for part in parts) or len(set(parts)) != len(parts):
        raise UsageProblem(f"--stiffness-orders {text}: write different whole numbers from 1 to 9, as 1,3")
    return tuple(int(part) for part in parts)
