import threading

import pytest
from scripted_board import ScriptedBoard, decay

from daq.errors import PortBusy, PortError
from daq.link import Link
from daq.port import Port, PortDescription
from daq.ports import Candidate, choose_port, list_ports, probe
from firmware_protocol import Hello

SAMPLES = decay(64)


def opener(name: str) -> Port:
    if name == "busy":
        raise PortBusy("busy: another program has this port; close it and try again")
    board = ScriptedBoard(SAMPLES)
    if name == "modem":
        board.write = lambda data: board._out.extend(b"AT OK\r\n")  # type: ignore[method-assign]
    if name == "version 9":
        board.hello = Hello(1, 1, major=9, minor=2)
    return board


def candidates(*names: str) -> tuple[Candidate, ...]:
    return tuple(probe(PortDescription(name), 0.4, opener) for name in names)


def test_a_board_answers_and_is_described() -> None:
    (found,) = candidates("board")
    assert found.answers
    assert found.hello is not None
    assert [channel.name for channel in found.channels] == ["x", "a"]


def test_a_device_that_is_no_board_is_described_by_what_it_sent() -> None:
    (found,) = candidates("modem")
    assert not found.answers
    assert "no answer of a board" in found.problem


def test_a_port_that_another_program_has_is_listed_with_its_problem() -> None:
    (found,) = candidates("busy")
    assert "another program" in found.problem


def test_a_board_of_another_version_is_a_board_that_answers() -> None:
    (found,) = candidates("version 9")
    assert found.answers
    assert "9.2" in found.problem


def test_the_only_port_that_answers_need_not_be_named() -> None:
    assert choose_port(None, lambda: candidates("modem", "board", "busy")) == "board"


def test_of_two_boards_one_must_be_named() -> None:
    with pytest.raises(PortError, match="2 boards answer"):
        choose_port(None, lambda: candidates("board", "another board"))
    assert choose_port("another board", lambda: candidates("board")) == "another board"


def test_no_board_is_reported_with_what_was_tried() -> None:
    with pytest.raises(PortError, match="modem"):
        choose_port(None, lambda: candidates("modem"))
    with pytest.raises(PortError, match="no serial port"):
        choose_port(None, tuple)


def test_named_ports_are_probed_too_and_those_that_answer_come_first() -> None:
    found = list_ports(["modem", "board"], 0.4, opener)
    assert found[0].answers
    assert {"modem", "board"} <= {candidate.port.name for candidate in found}


def test_a_closed_link_leaves_no_thread_and_no_open_port() -> None:
    board = ScriptedBoard(SAMPLES)
    with Link(board) as link:
        link.handshake()
    assert board.closed
    assert all("scripted" not in thread.name for thread in threading.enumerate())
