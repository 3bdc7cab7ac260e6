"""Which ports may be opened: a device of this computer, or a board behind a network address, and nothing else.

A port's name reaches the program from an option, from settings and from the page. pyserial takes more than ports:
`spy://` writes a file of one's choice, `alt://` loads a class, `hwgrep://` searches.
"""

import os
import stat
from urllib.parse import parse_qs, urlsplit

from daq.errors import PortError

NETWORK = ("socket", "rfc2217")
OPTIONS = {"ign_set_control", "poll_modem", "timeout"}
"""What some servers of rfc2217 need."""

LONGEST = 200
LONGEST_WAIT_S = 5.0
"""What a server of rfc2217 may be given to answer each of several questions."""


def fault_of(name: str) -> str:
    """Return in words why a name is none of a port; empty when it may be opened."""
    if not name or len(name) > LONGEST or not name.isprintable():
        return f"{name[:LONGEST]!r} is no name of a port"
    if "://" not in name:
        return ""
    host, short = None, True
    try:
        parts = urlsplit(name)
        host = parts.scheme in NETWORK and parts.hostname and parts.port and "@" not in parts.netloc
        more = set(parse_qs(parts.query, keep_blank_values=True)) - OPTIONS
        waits = [float(text) for text in parse_qs(parts.query, keep_blank_values=True).get("timeout", ())]
        short = all(0.0 < wait <= LONGEST_WAIT_S for wait in waits)
        plain = host and not more and short and not parts.fragment and parts.path in ("", "/")
    except ValueError:  # a port or a timeout that is no number
        plain = short = False
    if plain:
        return ""
    if host and not short:
        return f"{name}: its timeout must be a number of seconds, at most {LONGEST_WAIT_S:g}"
    return f"{name} is no port: a device as /dev/ttyACM0 or COM3, socket://HOST:PORT and rfc2217://HOST:PORT can be opened"


def require_port(name: str) -> None:
    """Raise PortError for what is no port, and for a device's name under which there is none."""
    if fault := fault_of(name):
        raise PortError(fault)
    if "://" in name or os.name == "nt":
        return
    try:
        is_device = stat.S_ISCHR(os.stat(name).st_mode)
    except OSError:  # opening says why
        return
    if not is_device:
        raise PortError(f"{name}: this is no device; plug the board in or list the ports")
