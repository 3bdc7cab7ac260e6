"""Whatever listens, listens on 127.0.0.1: asked of the kernel, while the real programs run."""

import os
import socket
import time
from pathlib import Path

import pytest

from mocks.in_process import running
from station.views.viewer import start

TCP = (Path("/proc/net/tcp"), Path("/proc/net/tcp6"))
LISTEN = "0A"
LOOPBACK = ("0100007F", "00000000000000000000000001000000")

pytestmark = pytest.mark.skipif(not TCP[0].exists(), reason="this system does not list its sockets in /proc")


def listening(pid: int) -> set[tuple[str, int]]:
    """Return (address in the kernel's hexadecimal, port) of every socket on which a process listens."""
    own = set()
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        try:
            own.add(os.readlink(entry))
        except OSError:  # closed meanwhile
            continue
    found = set()
    for table in TCP:
        for row in (line.split() for line in table.read_text().splitlines()[1:]):
            if row[3] == LISTEN and f"socket:[{row[9]}]" in own:
                address, _, port = row[1].partition(":")
                found.add((address, int(port, 16)))
    return found


def soon(pid: int, count: int) -> set[tuple[str, int]]:
    """Return the listening sockets once there are `count` of them, or what there is after 20 s."""
    until = time.monotonic() + 20.0
    while len(found := listening(pid)) < count and time.monotonic() < until:
        time.sleep(0.05)
    return found


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def test_the_check_sees_a_socket_that_is_open_to_the_world() -> None:
    with socket.create_server(("0.0.0.0", 0)) as wide:
        assert ("00000000", wide.getsockname()[1]) in listening(os.getpid())


def test_the_double_listens_on_this_machine_only() -> None:
    before = listening(os.getpid())
    with running("--tcp", "0") as address:
        found = listening(os.getpid()) - before
    assert {port for _, port in found} == {int(address.rpartition(":")[2])}
    assert {address for address, _ in found} <= set(LOOPBACK)


def test_the_viewer_listens_on_this_machine_only() -> None:
    ports = {free_port(), free_port()}
    web, grpc = (str(port) for port in ports)
    viewer = start("--serve-web", "--web-viewer-port", web, "--port", grpc)
    try:
        found = soon(viewer.pid, 2)
    finally:
        viewer.terminate()
        viewer.wait(timeout=10)
    assert {port for _, port in found} == ports
    assert {address for address, _ in found} <= set(LOOPBACK)
