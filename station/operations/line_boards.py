"""Boards that print lines, sound cards and sources of one's own, as a port that capture can use."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from daq.port import Port
from daq.sources import SourceBoard
from daq.sources.open_source import LineOptions, open_lines, open_source
from daq.sources.profiles import load_profile
from station.exits import UsageProblem
from station.output import progress
from station.settings import Settings


@dataclass(frozen=True)
class LineChoice:
    """What the operator said of a board that does not speak the protocol."""

    lines: bool
    profile: str | None
    source: str | None
    columns: Mapping[str, str]
    units: Mapping[str, str]
    rate: float | None
    baud: int | None

    @property
    def any(self) -> bool:
        """Whether the board does not speak the protocol. Raises UsageProblem where options contradict each other."""
        by_lines = self.lines or self.profile is not None
        if by_lines and self.source is not None:
            raise UsageProblem("--lines and --source are two kinds of board; give one of them")
        told = [
            o
            for o, given in (("--column", self.columns), ("--unit", self.units), ("--baud", self.baud))
            if given
        ]
        if told and not by_lines and self.source is None:
            raise UsageProblem(
                f"{told[0]} belongs to --lines or --source; a board of the protocol says it itself"
            )
        return by_lines or self.source is not None

    def options(self, settings: Settings) -> LineOptions:
        """Describe the lines. Raises SettingsError for a profile that is not there."""
        form = None if self.profile is None else load_profile(self.profile, profiles_of(settings))
        return LineOptions(form, dict(self.columns), self.units, self.rate, self.baud)


def profiles_of(settings: Settings) -> Path:
    """Return the folder of the profiles, beside the sessions."""
    return settings.sessions.parent / "profiles"


def board_behind(port: str, choice: LineChoice, settings: Settings) -> str | Port:
    """Return the port as it is named, or what stands before a source; it says whose clock it is."""
    if not choice.any:
        return port
    options = choice.options(settings)
    if choice.source is not None:
        board = SourceBoard(open_source(choice.source, options))
    elif not port:
        raise UsageProblem(
            "name the port whose lines are to be read, as --port /dev/ttyUSB0 (see `station ports`)"
        )
    else:
        progress(f"listening to {port} for some seconds")
        board = SourceBoard(open_lines(port, options))
    found = board.description
    channels = ", ".join(f"{c.quantity} '{c.name}' in {c.unit}" for c in found.channels)
    progress(f"{found.name}: {channels}")
    for remark in found.remarks:
        progress(remark)
    return board
