"""Boards that print lines, sound cards and sources of one's own, as a port that capture can use."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from daq.port import Port
from daq.ports import choose_port
from daq.sources import SourceBoard
from daq.sources.line_format import load_profile
from daq.sources.open_source import LineOptions, open_lines, open_source
from station.exits import UsageProblem
from station.output import progress
from station.settings import Settings


def profiles_of(settings: Settings) -> Path:
    """Return the folder of the profiles, beside the sessions."""
    return settings.sessions.parent / "profiles"


def board_behind(
    port: str | None,
    settings: Settings,
    told: LineOptions,
    lines: bool,
    profile: str | None,
    source: str | None,
) -> Callable[[], str | Port]:
    """Make the function that opens the board for each release: its port, or a source behind an adapter.

    The board speaks the protocol unless it prints `lines`, has a `profile`, or is another `source`; `told` is what the
    operator said of it. Raises UsageProblem where that is a contradiction, OperatorError for a profile that is not there.
    """
    named, by_lines = port or settings.capture.port, lines or profile is not None
    if by_lines and source is not None:
        raise UsageProblem("--lines and --source are two kinds of board; give one of them")
    if not by_lines and source is None:
        options = {"--column": told.columns, "--unit": told.units, "--baud": told.baud}
        if given := [option for option, value in options.items() if value]:
            raise UsageProblem(
                f"{given[0]} belongs to --lines or --source; a board of the protocol says it itself"
            )
        chosen = choose_port(named)
        return lambda: chosen
    if by_lines and not named:
        raise UsageProblem(
            "name the port whose lines are to be read, as --port /dev/ttyUSB0 (see `station ports`)"
        )
    if profile is not None:
        told = replace(told, form=load_profile(profile, profiles_of(settings)))

    def opened() -> Port:
        if source is not None:
            board = SourceBoard(open_source(source, told))
        else:
            progress(f"listening to {named} for some seconds")
            board = SourceBoard(open_lines(named or "", told))
        found = board.description
        channels = ", ".join(f"{c.quantity} '{c.name}' in {c.unit}" for c in found.channels)
        for line in (f"{found.name}: {channels}", *found.remarks):
            progress(line)
        return board

    return opened
