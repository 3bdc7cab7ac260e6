"""One colour for one thing, in every tab; distinct for colour-blind eyes (after Okabe and Ito).

The viewer is light or dark as its page is: every colour stands out from white and from black. A picture alone needs a
ground, since the viewer draws nothing through it.
"""

from contextvars import ContextVar
from dataclasses import dataclass

GROUNDS = {True: "#0d1011", False: "#ffffff"}
"""The ground of a picture, by whether the viewer is dark."""

ground: ContextVar[str] = ContextVar("ground", default=GROUNDS[True])

INK = "#7d8791"
FAINT = "#8d959e"

MEASURED = (125, 135, 145)
DISPLACEMENT = (30, 136, 200)
VELOCITY = (170, 130, 0)
ACCELERATION = (215, 125, 0)
WAVELET = (190, 100, 160)
FORCE = (0, 150, 110)
WRONG = (215, 90, 25)
REFERENCE = (130, 138, 148)

CHANNEL = {"displacement": DISPLACEMENT, "velocity": VELOCITY, "acceleration": ACCELERATION}


def css(colour: tuple[int, int, int]) -> str:
    """Return a colour as "#rrggbb", as matplotlib takes it."""
    return "#" + "".join(f"{part:02x}" for part in colour)


@dataclass(frozen=True)
class Look:
    """Colours of what is drawn: text, lines of reference, a measurement (as points, as a broad line), a model, a second
    curve, a residual, the noise's band and bars."""

    ink: str
    faint: str
    measured: str
    broad: str
    model: str
    second: str
    residual: str
    noise: str
    bar: str


SCREEN = Look(
    ink=INK,
    faint=FAINT,
    measured=css(MEASURED),
    broad=css(MEASURED),
    model=css(FORCE),
    second=css(ACCELERATION),
    residual=css(WRONG),
    noise="#00966e44",
    bar=css(FORCE),
)

PAPER = Look(
    ink="#111111",
    faint="#8c8c8c",
    measured="#7d7d7d",
    broad="#b5b5b5",
    model="#00447c",
    second="#111111",
    residual="#a63603",
    noise="#d4d4d4",
    bar="#c4c4c4",
)
