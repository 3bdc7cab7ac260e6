"""Which ports there are, and which of them answer as a board: a port must be named unless exactly one does."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from daq.errors import BoardError, PortError, StationError
from daq.link import Link
from daq.port import Port, PortDescription, open_port, system_ports
from daq.recording import Channel
from firmware_protocol import Hello

PROBE_S = 2.5
MOST_PROBED = 16


@dataclass(frozen=True)
class Candidate:
    """A port, and what answered there: `hello` and `channels`, or `problem` in words.

    `answers` is true for a board of this protocol, whatever its version.
    """

    port: PortDescription
    hello: Hello | None = None
    channels: tuple[Channel, ...] = ()
    problem: str = ""
    answers: bool = False


def probe(
    description: PortDescription, seconds: float = PROBE_S, opener: Callable[[str], Port] = open_port
) -> Candidate:
    """Ask HELLO at one port, for at most `seconds`; never raises for what is found there."""
    try:
        with Link(opener(description.name)) as link:
            hello = link.handshake(seconds)
            return Candidate(description, hello, link.assembly.channels, answers=True)
    except BoardError as error:
        return Candidate(description, problem=str(error), answers=True)
    except StationError as error:
        return Candidate(description, problem=str(error))


def list_ports(
    names: Iterable[str] = (), seconds: float = PROBE_S, opener: Callable[[str], Port] = open_port
) -> tuple[Candidate, ...]:
    """Probe the computer's serial ports and the named ones, all at once; those that answer come first."""
    known = {port.name: port for port in system_ports()}
    known |= {name: PortDescription(name) for name in names if name not in known}
    ports = list(known.values())[:MOST_PROBED]
    if not ports:
        return ()
    with ThreadPoolExecutor(len(ports)) as pool:
        found = list(pool.map(lambda port: probe(port, seconds, opener), ports))
    return tuple(sorted(found, key=lambda candidate: not candidate.answers))


def choose_port(name: str | None, candidates: Callable[[], tuple[Candidate, ...]] = list_ports) -> str:
    """Return `name`, or without one the only port that answers; PortError where none does, or several."""
    if name:
        return name
    found = candidates()
    answering = [candidate.port.name for candidate in found if candidate.answers]
    if len(answering) == 1:
        return answering[0]
    if answering:
        raise PortError(f"{len(answering)} boards answer ({', '.join(answering)}); name one of them")
    raise PortError(_nobody(found))


def _nobody(found: tuple[Candidate, ...]) -> str:
    if not found:
        return "this computer has no serial port; plug the board in, or name a port"
    names = ", ".join(candidate.port.name for candidate in found[:5])
    return f"no board answers at {names}; plug it in, or name its port"
