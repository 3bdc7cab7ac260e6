"""`station ports`: list the ports on which a board may be."""

from typing import Any

from station.commands.options import argument, declared


@declared("ports")
def command(
    ports: tuple[str, ...] = argument(nargs=-1),
) -> None:
    """List the serial ports, and which of them answer as a board.

    Further PORTS to ask may be named, as socket://HOST:PORT. A board may be
    reset by asking it.
    """
    from daq.ports import list_ports
    from station.text.content import Table, Told
    from station.text.layout import answer

    found = list_ports(ports)
    none = "" if found else "this computer has no serial port; is the board plugged in?"
    table = Table("", ("", ""), tuple((one.port.name, _said(one)) for one in found), texts=2)
    boards = [candidate.port.name for candidate in found if candidate.hello is not None]
    step = ("capture", "--port", boards[0]) if boards else ("doctor",)
    document = {"ports": [_entry(candidate) for candidate in found]}
    answer(document, Told(none, "", (table,)), *step)


def _entry(candidate: Any) -> dict[str, Any]:
    hello = candidate.hello
    return {
        "name": candidate.port.name,
        "description": getattr(candidate.port, "description", ""),
        "answers": candidate.answers,
        "board": None if hello is None else hello.board,
        "firmware": None if hello is None else hello.firmware,
        "channels": [{"name": c.name, "quantity": c.quantity, "unit": c.unit} for c in candidate.channels],
        "problem": candidate.problem,
    }


def _said(candidate: Any) -> str:
    if candidate.hello is None:
        return str(candidate.problem).removeprefix(f"{candidate.port.name}: ")
    names = ", ".join(f"{channel.name} [{channel.unit}]" for channel in candidate.channels)
    return f"{candidate.hello.board}: {names}"
