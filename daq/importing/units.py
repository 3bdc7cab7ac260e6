"""Units as people write them, and what they are in SI."""

import re
from dataclasses import dataclass

STANDARD_GRAVITY = 9.80665
RADIAN_PER_DEGREE = 0.017453292519943295
RADIAN_PER_TURN = 6.283185307179586
INCH = 0.0254


@dataclass(frozen=True)
class Unit:
    """One unit: `value * scale` is in `si`. `quantity` is None for an electrical or raw signal (V, A, counts)."""

    scale: float
    si: str
    quantity: str | None

    @property
    def angular(self) -> bool:
        """True for an angle, its derivatives, and a moment."""
        return self.si.startswith(("rad", "N m"))


SECOND = Unit(1.0, "s", "time")
COUNT = Unit(1.0, "count", None)
SI_LINEAR = {
    "time": SECOND,
    "displacement": Unit(1.0, "m", "displacement"),
    "velocity": Unit(1.0, "m/s", "velocity"),
    "acceleration": Unit(1.0, "m/s^2", "acceleration"),
    "force": Unit(1.0, "N", "force"),
}
SI_ANGULAR = {
    "time": SECOND,
    "displacement": Unit(1.0, "rad", "displacement"),
    "velocity": Unit(1.0, "rad/s", "velocity"),
    "acceleration": Unit(1.0, "rad/s^2", "acceleration"),
    "force": Unit(1.0, "N m", "force"),
}

_LENGTHS = {
    "m": 1.0,
    "dm": 1e-1,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "nm": 1e-9,
    "km": 1e3,
    "in": INCH,
    "inch": INCH,
    "ft": 12 * INCH,
    "mil": 1e-3 * INCH,
    "м": 1.0,
    "см": 1e-2,
    "мм": 1e-3,
    "мкм": 1e-6,
}
_LENGTH_WORDS = {
    "meter": 1.0,
    "meters": 1.0,
    "metre": 1.0,
    "metres": 1.0,
    "millimeter": 1e-3,
    "millimeters": 1e-3,
    "millimetre": 1e-3,
    "centimeter": 1e-2,
    "centimeters": 1e-2,
    "micron": 1e-6,
    "microns": 1e-6,
    "micrometer": 1e-6,
    "inches": INCH,
    "feet": 12 * INCH,
    "mils": 1e-3 * INCH,
}
_ANGLES = {
    "rad": 1.0,
    "mrad": 1e-3,
    "urad": 1e-6,
    "deg": RADIAN_PER_DEGREE,
    "°": RADIAN_PER_DEGREE,
    "grad": RADIAN_PER_DEGREE,
    "degree": RADIAN_PER_DEGREE,
    "degrees": RADIAN_PER_DEGREE,
    "radian": 1.0,
    "radians": 1.0,
    "rev": RADIAN_PER_TURN,
    "turn": RADIAN_PER_TURN,
    "рад": 1.0,
}
_TIMES = {
    "s": 1.0,
    "sec": 1.0,
    "secs": 1.0,
    "second": 1.0,
    "seconds": 1.0,
    "sek": 1.0,
    "sekunden": 1.0,
    "seg": 1.0,
    "segundos": 1.0,
    "secondes": 1.0,
    "secondi": 1.0,
    "с": 1.0,
    "сек": 1.0,
    "秒": 1.0,
    "ms": 1e-3,
    "msec": 1e-3,
    "millis": 1e-3,
    "milliseconds": 1e-3,
    "мс": 1e-3,
    "us": 1e-6,
    "usec": 1e-6,
    "micros": 1e-6,
    "microseconds": 1e-6,
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}
_FORCES = {
    "N": Unit(1.0, "N", "force"),
    "kN": Unit(1e3, "N", "force"),
    "mN": Unit(1e-3, "N", "force"),
    "newton": Unit(1.0, "N", "force"),
    "newtons": Unit(1.0, "N", "force"),
    "lbf": Unit(4.4482216152605, "N", "force"),
    "lb": Unit(4.4482216152605, "N", "force"),
    "lbs": Unit(4.4482216152605, "N", "force"),
    "kip": Unit(4448.2216152605, "N", "force"),
    "kgf": Unit(STANDARD_GRAVITY, "N", "force"),
    "Н": Unit(1.0, "N", "force"),
    "Nm": Unit(1.0, "N m", "force"),
    "N*m": Unit(1.0, "N m", "force"),
    "mNm": Unit(1e-3, "N m", "force"),
    "kNm": Unit(1e3, "N m", "force"),
    "Ncm": Unit(1e-2, "N m", "force"),
    "Nmm": Unit(1e-3, "N m", "force"),
}
_SIGNALS = {
    "V": Unit(1.0, "V", None),
    "mV": Unit(1e-3, "V", None),
    "uV": Unit(1e-6, "V", None),
    "volt": Unit(1.0, "V", None),
    "volts": Unit(1.0, "V", None),
    "A": Unit(1.0, "A", None),
    "mA": Unit(1e-3, "A", None),
    "counts": Unit(1.0, "count", None),
    "count": Unit(1.0, "count", None),
    "lsb": Unit(1.0, "count", None),
    "digits": Unit(1.0, "count", None),
    "au": Unit(1.0, "count", None),
    "a.u": Unit(1.0, "count", None),
    "arb": Unit(1.0, "count", None),
    "arb.u": Unit(1.0, "count", None),
    "ticks": Unit(1.0, "count", None),
    "steps": Unit(1.0, "count", None),
    "bits": Unit(1.0, "count", None),
    "px": Unit(1.0, "px", None),
    "pixel": Unit(1.0, "px", None),
    "pixels": Unit(1.0, "px", None),
    "Hz": Unit(1.0, "Hz", None),
    "kHz": Unit(1e3, "Hz", None),
    "%": Unit(1.0, "%", None),
    "°C": Unit(1.0, "degC", None),
    "degC": Unit(1.0, "degC", None),
    "K": Unit(1.0, "K", None),
    "Pa": Unit(1.0, "Pa", None),
    "bar": Unit(1e5, "Pa", None),
    "kg": Unit(1.0, "kg", None),
}
_ACCELERATIONS = {
    "g": STANDARD_GRAVITY,
    "gn": STANDARD_GRAVITY,
    "g0": STANDARD_GRAVITY,
    "g_n": STANDARD_GRAVITY,
    "mg": STANDARD_GRAVITY * 1e-3,
    "ug": STANDARD_GRAVITY * 1e-6,
    "gal": 1e-2,
}


def _table() -> dict[str, Unit]:
    units: dict[str, Unit] = dict(_FORCES) | dict(_SIGNALS)
    units |= {name: Unit(scale, "s", "time") for name, scale in _TIMES.items()}
    units |= {name: Unit(s, "m", "displacement") for name, s in (_LENGTHS | _LENGTH_WORDS).items()}
    units |= {name: Unit(scale, "rad", "displacement") for name, scale in _ANGLES.items()}
    units |= {name: Unit(scale, "m/s^2", "acceleration") for name, scale in _ACCELERATIONS.items()}
    for lengths, si in ((_LENGTHS, "m"), (_ANGLES, "rad")):
        for name, scale in lengths.items():
            for second in ("s", "sec", "с"):
                for form in (
                    f"{name}/{second}",
                    f"{name}{second}-1",
                    f"{name}_{second}",
                    f"{name}.{second}-1",
                ):
                    units[form] = Unit(scale, f"{si}/s", "velocity")
                for form in (
                    f"{name}/{second}2",
                    f"{name}/{second}/{second}",
                    f"{name}/({second}2)",
                    f"{name}{second}-2",
                    f"{name}.{second}-2",
                    f"{name}_{second}2",
                    f"{name}_{second}_2",
                    f"{name}_{second}_{second}",
                    f"{name}/({second}*{second})",
                ):
                    units[form] = Unit(scale, f"{si}/s^2", "acceleration")
            units[f"{name}ps"] = Unit(scale, f"{si}/s", "velocity")
            units[f"{name}ps2"] = Unit(scale, f"{si}/s^2", "acceleration")
            units[f"{name}_per_s"] = Unit(scale, f"{si}/s", "velocity")
            units[f"{name}_per_s2"] = Unit(scale, f"{si}/s^2", "acceleration")
    units |= {
        "dps": Unit(RADIAN_PER_DEGREE, "rad/s", "velocity"),
        "ips": Unit(INCH, "m/s", "velocity"),
        "km/h": Unit(1 / 3.6, "m/s", "velocity"),
        "rpm": Unit(RADIAN_PER_TURN / 60, "rad/s", "velocity"),
        "1/min": Unit(RADIAN_PER_TURN / 60, "rad/s", "velocity"),
        "U/min": Unit(RADIAN_PER_TURN / 60, "rad/s", "velocity"),
    }
    return units


UNITS = _table()
_LOWER: dict[str, Unit] = {}
for _name, _unit in UNITS.items():
    _LOWER.setdefault(_name.lower(), _unit)
_FOLD = str.maketrans(
    {
        "µ": "u",
        "μ": "u",
        "²": "2",
        "³": "3",
        "⁻": "-",
        "¹": "1",
        "−": "-",
        "·": ".",
        "⋅": ".",
        "º": "°",
        "^": None,
        "{": None,
        "}": None,
        " ": None,
        "\u00a0": None,
    }
)
_SCALED = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*\*?\s*(\D.*)")


def parse_unit(text: str) -> Unit | None:
    """Return the unit that `text` spells (`mm`, `m/s²`, `m_s2`, `°/s`, `g`), or None."""
    if len(text) > 24:
        return None
    folded = text.translate(_FOLD).replace("**", "").strip(".,:")
    if not folded:
        return None
    return UNITS.get(folded) or _LOWER.get(folded.lower())


def parse_scaled_unit(text: str) -> Unit | None:
    """Return the unit that an option gives: a unit, or a number and a unit such as `0.0025 m`."""
    match = _SCALED.fullmatch(text[:60])
    if match is None or parse_unit(text) is not None:
        return parse_unit(text)
    unit = parse_unit(match[2])
    scale = float(match[1])
    if unit is None or not 0.0 < abs(scale) < 1e30:
        return None
    return Unit(scale * unit.scale, unit.si, unit.quantity)
