"""One colour for one thing, in every tab; distinct for colour-blind eyes (after Okabe and Ito)."""

BACKGROUND = (16, 18, 22)
PANEL = "#101216"
INK = "#d7dce2"
FAINT = "#59616b"

MEASURED = (200, 206, 214)
DISPLACEMENT = (86, 180, 233)
VELOCITY = (240, 228, 66)
ACCELERATION = (230, 159, 0)
WAVELET = (214, 139, 186)
FORCE = (40, 190, 140)
WRONG = (225, 96, 30)
REFERENCE = (120, 130, 142)

CHANNEL = {"displacement": DISPLACEMENT, "velocity": VELOCITY, "acceleration": ACCELERATION}


def css(colour: tuple[int, int, int]) -> str:
    """Return a colour as "#rrggbb", as matplotlib takes it."""
    return "#" + "".join(f"{part:02x}" for part in colour)
