"""Units as people write them, and what they are in SI."""

import re
from dataclasses import dataclass

STANDARD_GRAVITY = 9.80665
RADIAN_PER_DEGREE = 0.017453292519943295
RADIAN_PER_TURN = 6.283185307179586
INCH = 0.0254
POUND = 4.4482216152605


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


def _si(*units: str) -> dict[str, Unit]:
    quantities = ("time", "displacement", "velocity", "acceleration", "force")
    return {q: Unit(1.0, unit, q) for q, unit in zip(quantities, units, strict=True)}


SI_LINEAR = _si("s", "m", "m/s", "m/s^2", "N")
SI_ANGULAR = _si("s", "rad", "rad/s", "rad/s^2", "N m")

_PREFIXES = {"": 1.0, "k": 1e3, "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9}
_LENGTHS = {f"{prefix}m": scale for prefix, scale in _PREFIXES.items()} | {
    "in": INCH, "inch": INCH, "ft": 12 * INCH, "mil": 1e-3 * INCH, "м": 1.0, "см": 1e-2, "мм": 1e-3, "мкм": 1e-6,
}  # fmt: skip
_ANGLES = {
    "rad": 1.0, "mrad": 1e-3, "urad": 1e-6, "radian": 1.0, "radians": 1.0, "рад": 1.0,
    **dict.fromkeys(("deg", "°", "grad", "degree", "degrees"), RADIAN_PER_DEGREE),
    "rev": RADIAN_PER_TURN, "turn": RADIAN_PER_TURN,
}  # fmt: skip
_WORDS = {
    "displacement": {
        **{f"{word}{met}{s}": scale for word, scale in (("", 1.0), ("centi", 1e-2), ("milli", 1e-3), ("micro", 1e-6))
           for met in ("meter", "metre") for s in ("", "s")},
        "micron": 1e-6, "microns": 1e-6, "inches": INCH, "feet": 12 * INCH, "mils": 1e-3 * INCH,
    },
    "time": {
        **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "sek", "sekunden", "seg", "segundos", "secondes",
                         "secondi", "с", "сек", "秒"), 1.0),
        **dict.fromkeys(("ms", "msec", "millis", "milliseconds", "мс"), 1e-3),
        **dict.fromkeys(("us", "usec", "micros", "microseconds"), 1e-6), "ns": 1e-9, "min": 60.0, "h": 3600.0,
    },
    "acceleration": {
        **dict.fromkeys(("g", "gn", "g0", "g_n"), STANDARD_GRAVITY), "mg": STANDARD_GRAVITY * 1e-3,
        "ug": STANDARD_GRAVITY * 1e-6, "gal": 1e-2,
    },
    "force": {
        "N": 1.0, "kN": 1e3, "mN": 1e-3, "newton": 1.0, "newtons": 1.0, "Н": 1.0, "kgf": STANDARD_GRAVITY,
        "kip": 1e3 * POUND, **dict.fromkeys(("lbf", "lb", "lbs"), POUND),
    },
    "moment": {"Nm": 1.0, "N*m": 1.0, "mNm": 1e-3, "kNm": 1e3, "Ncm": 1e-2, "Nmm": 1e-3},
}  # fmt: skip
_SIGNALS = {
    "V": {"V": 1.0, "mV": 1e-3, "uV": 1e-6, "volt": 1.0, "volts": 1.0},
    "A": {"A": 1.0, "mA": 1e-3},
    "count": dict.fromkeys(
        ("counts", "count", "lsb", "digits", "au", "a.u", "arb", "arb.u", "ticks", "steps", "bits"), 1.0
    ),
    "px": dict.fromkeys(("px", "pixel", "pixels"), 1.0),
    "Hz": {"Hz": 1.0, "kHz": 1e3}, "%": {"%": 1.0}, "degC": {"°C": 1.0, "degC": 1.0}, "K": {"K": 1.0},
    "Pa": {"Pa": 1.0, "bar": 1e5}, "kg": {"kg": 1.0},
}  # fmt: skip


def _table() -> dict[str, Unit]:
    si = SI_LINEAR | {"moment": SI_ANGULAR["force"]}
    units = {name: Unit(k, unit, None) for unit, names in _SIGNALS.items() for name, k in names.items()}
    units |= {
        name: Unit(k, si[q].si, si[q].quantity) for q, names in _WORDS.items() for name, k in names.items()
    }
    for lengths, base in ((_LENGTHS, "m"), (_ANGLES, "rad")):
        for name, scale in lengths.items():
            units[name] = Unit(scale, base, "displacement")
            for s in ("s", "sec", "с"):
                for form in (f"/{s}", f"{s}-1", f"_{s}", f".{s}-1", "ps", "_per_s"):
                    units[name + form] = Unit(scale, f"{base}/s", "velocity")
                for form in (
                    f"/{s}2", f"/{s}/{s}", f"/({s}2)", f"{s}-2", f".{s}-2", f"_{s}2", f"_{s}_2", f"_{s}_{s}",
                    f"/({s}*{s})", "ps2", "_per_s2",
                ):  # fmt: skip
                    units[name + form] = Unit(scale, f"{base}/s^2", "acceleration")
    turning = RADIAN_PER_TURN / 60
    units |= {name: Unit(turning, "rad/s", "velocity") for name in ("rpm", "1/min", "U/min")}
    return units | {
        "dps": Unit(RADIAN_PER_DEGREE, "rad/s", "velocity"),
        "ips": Unit(INCH, "m/s", "velocity"),
        "km/h": Unit(1 / 3.6, "m/s", "velocity"),
    }


UNITS = _table()
_LOWER = {name.lower(): unit for name, unit in reversed(UNITS.items())}
_FOLD = str.maketrans("µμ²³⁻¹−·⋅º", "uu23-1-..°", "^{} \u00a0")
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
