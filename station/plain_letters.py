"""Letters for a terminal that has few: what its encoding lacks is written in the plain letters nearest to it."""

import codecs
import sys
import unicodedata
from typing import TextIO

NAME = "station-plain"
PLAIN = {"±": "+-", "×": "x", "÷": "/", "°": " deg", "µ": "u", "μ": "mu_", "σ": "sigma", "−": "-", "–": "-", "─": "-",
         "·": ".", "…": "...", "π": "pi", "ζ": "zeta", "ü": "u''", "\N{REPLACEMENT CHARACTER}": "?"}  # fmt: skip
RAISED = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True))


def write_what_the_terminal_has(*streams: TextIO) -> None:
    """Let streams write plain letters for those that their encoding lacks, in place of ending in an error."""
    codecs.register_error(NAME, _plain)
    for stream in streams:
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors=NAME)


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    return in_plain_letters(text, after=error.object[error.start - 1 : error.start]), error.end


def writable(text: str) -> str:
    """Return a text as the terminal can show it, before it is set: plain letters may be more than those they stand for."""
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except UnicodeEncodeError:
        return in_plain_letters(text)
    return text


def in_plain_letters(text: str, after: str = "") -> str:
    """Write each letter that ASCII lacks in plain ones, as "m/s^2" for "m/s²"; "?" where there are none."""
    written = []
    for letter in text:
        if letter in RAISED:
            written.append(f"{'' if after in RAISED else '^'}{RAISED[letter]}")
        elif letter in PLAIN or letter.isascii():
            written.append(PLAIN.get(letter, letter))
        else:
            near = unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode()
            written.append(near or "?")
        after = letter
    return "".join(written)
