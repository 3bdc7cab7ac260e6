"""What the double's TCP line offers to the world: nothing but 127.0.0.1."""

from mocks.link import TcpLink


def test_the_double_listens_on_this_machine_only() -> None:
    link = TcpLink()
    try:
        assert link._listener.getsockname()[0] == "127.0.0.1"
    finally:
        link.close()
