"""A board that may be booting is not spoken to before it has spoken."""

import pytest

from daq import link as link_module
from daq.errors import BoardError
from daq.link import Link
from daq.port import may_have_reset_the_board, open_port
from firmware_protocol import Heartbeat, encode
from mocks.in_process import running


class BootingPort:
    """A port whose board is silent, sends a heartbeat at the fourth read, and then keeps silent."""

    name = "booting"

    def __init__(self) -> None:
        self.reads = 0
        self.written_after: list[int] = []

    def read(self) -> bytes:
        self.reads += 1
        return encode(Heartbeat(500_000, 0, 0), 0) if self.reads == 4 else b""

    def write(self, data: bytes) -> None:
        self.written_after.append(self.reads)

    def close(self) -> None:
        pass


def test_nothing_is_sent_before_the_first_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_module, "may_have_reset_the_board", lambda port: True)
    port = BootingPort()
    with Link(port) as link, pytest.raises(BoardError, match="none was the HELLO"):
        link.handshake(0.1)
    assert port.written_after
    assert min(port.written_after) >= 4


@pytest.mark.parametrize("line", [["--pty"], ["--tcp", "0"]])
def test_ptys_and_sockets_are_asked_at_once(line: list[str]) -> None:
    with running(*line) as address:
        port = open_port(address)
        assert not may_have_reset_the_board(port)
        port.close()
