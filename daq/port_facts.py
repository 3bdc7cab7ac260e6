"""The system's facts about a port, without opening it: who holds it, its latency."""

import os
from dataclasses import dataclass
from pathlib import Path

PROC = Path("/proc")
SYSTEM_TTY = Path("/sys/class/tty")


@dataclass(frozen=True)
class PortFacts:
    """`holders` are the programs (name, pid) that have it open, as far as this user may see them.

    `latency_ms` is that of an FTDI adapter, None where the system does not know it.
    """

    holders: tuple[tuple[str, int], ...]
    latency_ms: int | None


def port_facts(name: str, proc: Path = PROC, tty: Path = SYSTEM_TTY) -> PortFacts:
    """Return the facts of a device; of a URL (`socket://...`) nothing is known."""
    if "://" in name:
        return PortFacts((), None)
    device = os.path.realpath(name)
    return PortFacts(_holders(device, proc), _latency(device, tty))


def _holders(device: str, proc: Path) -> tuple[tuple[str, int], ...]:
    """Look through /proc/PID/fd (Linux); other users' programs stay unseen without their rights."""
    found = []
    for process in sorted(proc.glob("[0-9]*")):
        pid = int(process.name)
        if pid == os.getpid() or not _has_open(process, device):
            continue
        try:
            found.append(((process / "comm").read_text(errors="replace").strip(), pid))
        except OSError:
            continue
    return tuple(found)


def _has_open(process: Path, device: str) -> bool:
    try:
        return any(os.path.realpath(entry) == device for entry in (process / "fd").iterdir())
    except OSError:
        return False


def _latency(device: str, tty: Path) -> int | None:
    try:
        return int((tty / Path(device).name / "device" / "latency_timer").read_text())
    except (OSError, ValueError):
        return None
