"""One colour for one thing, in every tab; distinct for colour-blind eyes (after Okabe and Ito).

The viewer is light or dark as its page is: every colour of its curves stands out from white and from black.
"""

from dataclasses import dataclass, replace

MEASURED = (125, 135, 145)
DISPLACEMENT = (30, 136, 200)
VELOCITY = (170, 130, 0)
ACCELERATION = (215, 125, 0)
WAVELET = (190, 100, 160)
FORCE = (0, 150, 110)
WRONG = (215, 90, 25)

CHANNEL = {"displacement": DISPLACEMENT, "velocity": VELOCITY, "acceleration": ACCELERATION}


@dataclass(frozen=True)
class Look:
    """Colours of what is drawn: text, lines of reference, a measurement (as points, as a broad line or bar), a model, a
    second curve or residual, the noise's band; the ground, and the colours of a force: negative, none, positive."""

    ink: str
    faint: str
    measured: str
    broad: str
    model: str
    second: str
    noise: str
    paper: str = "#ffffff"
    force: tuple[str, str, str] = ("#005aa0", "#dfe3e7", "#c85000")


LIGHT = Look(
    ink="#1d2530",
    faint="#8c959f",
    measured="#8c959f",
    broad="#b3bcc6",
    model="#d55e00",
    second="#0072b2",
    noise="#00967033",
)
DARK = Look(
    ink="#e4e8ee",
    faint="#7c8794",
    measured="#9aa5b2",
    broad="#66717e",
    model="#f0903c",
    second="#56b4e9",
    noise="#3cc89640",
    paper="#171c23",
    force=("#56b4e9", "#3a434e", "#f0903c"),
)
PAGE = {True: DARK, False: LIGHT}
"""Of the workbench's page, by whether that is dark, in the colours of its style sheet; report and notebook are light."""

VIEWERS = PAGE | {True: replace(DARK, paper="#0d1011")}
"""Of a picture in the viewer; the paper is the viewer's own ground."""
