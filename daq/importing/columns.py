"""The meaning of a header: a quantity, in the words of several languages, and a unit."""

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache

from daq.importing.units import Unit, parse_unit

# Whole words, lower case, without accents; a word of five letters or more also matches as a beginning.
# Acceleration comes before velocity and displacement: its Chinese and Japanese names contain theirs.
WORDS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("acceleration", (
        "acceleration", "accelerometer", "accel", "acc", "accn", "beschleunigung", "beschl", "aceleracion", "aceleracao",
        "accelerazione", "accelerometro", "versnelling", "przyspieszenie", "zrychleni", "akceleration",
        "acceleratie", "ускорение", "прискорення", "kiihtyvyys", "ivme", "gyorsulas", "akceleracija",
        "pospesek", "akselerasjon", "加速度", "가속도",
    )),
    ("velocity", (
        "velocity", "vel", "velo", "speed", "geschwindigkeit", "winkelgeschwindigkeit", "geschw", "schnelle",
        "vitesse", "velocidad", "velocita", "velocidade", "snelheid", "hastighet", "hastighed", "predkosc",
        "rychlost", "rychlosti", "скорость", "швидкість", "nopeus", "hiz", "sebesseg", "brzina", "hitrost", "omega", "gyro",
        "vibrometer", "速度", "속도",
    )),
    ("force", (
        "force", "kraft", "fuerza", "forza", "forca", "kracht", "sila", "сила", "voima", "kuvvet", "ero", "torque",
        "moment", "drehmoment", "couple", "力", "힘",
    )),
    ("displacement", (
        "displacement", "disp", "displ", "position", "pos", "weg", "auslenkung", "verschiebung", "verlagerung",
        "elongation", "elongacion", "elongacao", "elongazione", "hub",
        "deplacement", "depl", "desplazamiento", "posicion", "spostamento", "posizione",
        "deslocamento", "posicao", "verplaatsing", "positie", "uitwijking", "forskydning", "forskjutning",
        "forskyvning", "lage", "posisjon", "przemieszczenie", "wychylenie", "polozenie", "poloha", "vychylka",
        "смещение", "перемещение", "положение", "отклонение", "переміщення", "konum", "siirtyma", "asema",
        "elmozdulas", "pomak", "angle", "winkel", "drehwinkel", "ausschlag", "angulo", "angolo", "hoek",
        "vinkel", "kat", "uhel", "угол", "кут", "kulma", "aci", "angular", "rotation", "distance", "abstand", "distanz",
        "distancia", "distanza", "afstand", "entfernung", "deflection", "durchbiegung", "lvdt", "stroke",
        "elevation", "encoder", "roll", "pitch", "yaw",
        "位移", "变位", "変位", "位置", "角度", "距离", "변위", "위치", "각도",
    )),
    ("time", (
        "time", "zeit", "uhrzeit", "temps", "tiempo", "tempo", "tijd", "tid", "czas", "время", "час", "cas", "ido",
        "aika", "zaman", "vreme", "timestamp", "ts", "zeitstempel", "horodatage", "millis", "micros", "elapsed",
        "datetime", "seconds", "sekunden", "时间", "時間", "时刻", "시간",
    )),
)  # fmt: skip
# A column with one of these words is something else, whatever else its header says.
OTHERS = frozenset({
    "fft", "spectrum", "spektrum", "psd", "asd", "frequenz", "frequency", "freq", "hz", "temperature", "temperatur",
    "temp", "sollwert", "soll", "target", "setpoint", "reference", "command", "std", "stdev", "error", "fehler", "err",
    "residual", "fit", "tg", "status", "flag", "quality", "humidity", "pressure", "battery", "envelope", "magnitude",
    "momentum", "energy", "energie", "power", "confidence",
})  # fmt: skip
DERIVED = (
    "ableitung", "derivative", "derived", "derivee", "derivada", "derivata", "afgeleide", "dxdt", "dvdt",
)  # fmt: skip
ANGULAR = (
    "angle", "winkel", "angular", "angulaire", "angulo", "angolo", "hoek", "vinkel", "kulma", "угол", "角度", "rotation",
    "drehwinkel", "winkelgeschwindigkeit", "winkelbeschleunigung", "phi", "theta", "psi", "alpha", "omega", "roll",
    "φ", "θ", "ψ", "ω", "pitch", "yaw", "gyro", "torque", "drehmoment", "moment", "encoder", "uhel", "각도",
)  # fmt: skip
INDEX = frozenset({"index", "sample", "samples", "nr", "no", "number", "n", "i", "#", "row", "point", "id"})
_LETTERS = {
    "t": "time",
    **dict.fromkeys(("x", "y", "z", "u", "d", "q", "s", "phi", "theta", "psi", "alpha", "φ", "θ"), "displacement"),
    "v": "velocity", "ω": "velocity", "a": "acceleration", "f": "force",
}  # fmt: skip
_LETTER = re.compile(r"(?:([va])[xyz]|([tuaxyz]|phi|theta|psi|alpha)\d{1,2})")
KINDS = frozenset({
    "raw", "filt", "filtered", "smooth", "smoothed", "lp", "corr", "corrected", "cal", "calibrated", "mean", "avg",
    "x", "y", "z", "left", "right",
})  # fmt: skip
"""Words behind a unit that say which reading it is."""

_RUN_WORDS = (
    "run|trial|test|messung|versuch|lauf|durchgang|release|take|repeat|repetition|series|serie|reihe|essai|mesure|"
    "prova|ensayo|meting|data ?set|recording|decay"
)
RUN_AND_NUMBER = re.compile(
    rf"[\s,_:;./-]*(?<![a-z])(?:{_RUN_WORDS})[\s_]*(?:nr|no)?[\s._#:-]*(\d{{1,4}}|(?-i:[A-H]))(?![a-z0-9])[\s,:;_-]*",
    re.I,
)
_UNIT_FORMS = (
    re.compile(r"(.*)\[([^\[\]]{0,24})\]\s*$", re.S),
    re.compile(r"(.*)\(([^()]{0,20}(?:\([^()]{0,10}\))?)\)\s*$", re.S),
    re.compile(r"(.*?)\s+/\s*(\S.{0,24})$", re.S),
    re.compile(r"(.*\S)\s+(?!A$)(\S{1,12})$", re.S),  # a letter A alone names a channel
    re.compile(r"([^/]*[^\W_])/(\S{1,12}/\S{1,12})$", re.S),
    re.compile(r"(.*[^\W_]/?)/(\S{1,12})$", re.S),
)


@dataclass(frozen=True)
class Meaning:
    """What a header seems to say; `strength` is 3 for a word, 2 for a unit, 1 for a mere letter, 0 for nothing."""

    quantity: str | None
    strength: int
    unit: Unit | None
    unit_text: str
    angular: bool
    derived: bool
    other: bool


def split_unit(header: str) -> tuple[str, str, Unit | None]:
    """Return the name in a header, the unit's text and the unit: `Position (mm)`, `Weg / rad`, `acc [g]`, `time_s`.

    Where a header ends in no unit, one before the word and the number of a run counts: `Position (mm) Run #1`.
    """
    header = " ".join(header[:200].split())
    found = _split(header)
    before = found if found[2] else _split(RUN_AND_NUMBER.sub(" ", header).strip())
    return before if before[0] and before[2] else found


def _split(header: str) -> tuple[str, str, Unit | None]:
    for form in _UNIT_FORMS:
        match = form.fullmatch(header)
        if match and (unit := parse_unit(match[2])):
            return match[1].strip(), match[2].strip(), unit
    parts = header.split("_")
    end = len(parts)
    while end > 1 and (parts[end - 1].casefold() in KINDS or parts[end - 1].isdigit()):
        end -= 1
    for stop in (len(parts), end):
        for size in (3, 2, 1):  # acceleration_m_s_2, acceleration_m_s2, time_s, angle_deg_raw
            text = "_".join(parts[stop - size : stop])
            known = stop == len(parts) or len(text) > 1 or text in ("g", "V")
            if stop > size and known and (unit := parse_unit(text)):
                return "_".join((*parts[: stop - size], *parts[stop:])), text, unit
    unit = parse_unit(header) if len(header) > 1 or header in ("m", "g", "N", "°") else None
    return ("", header, unit) if unit else (header, "", None)


def words(name: str) -> tuple[str, ...]:
    """Return the words of a name: lower case, without accents, split at signs, underscores and humps."""
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    flat = _without_accents(name.lower()).replace("ł", "l").replace("ø", "o")
    return tuple(w for w in re.split(r"[\W_]+", flat) if w)


@lru_cache(maxsize=4096)
def _without_accents(text: str) -> str:
    return "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))


@lru_cache(maxsize=1 << 16)
def _spells(word: str, stems: tuple[str, ...]) -> bool:
    for stem in stems:
        folded = _without_accents(stem)
        if word == folded or (len(folded) >= 5 and word.startswith(folded) and word not in OTHERS):
            return True
        if not stem.isascii() and stem in unicodedata.normalize("NFC", word) and ord(stem[0]) > 0x2E80:
            return True
    return False


def _letter(name_words: tuple[str, ...]) -> str | None:
    if any(len(word) > 2 and word not in _LETTERS and not _LETTER.fullmatch(word) for word in name_words):
        return None
    for word in name_words:
        if word in _LETTERS:
            return _LETTERS[word]
        if match := _LETTER.fullmatch(word):
            return _LETTERS[match[1] or match[2]]
    return None


@lru_cache(maxsize=1 << 13)
def meaning(header: str, unit_row: str = "") -> Meaning:
    """Read a header, and the cell of a unit row under it."""
    name, unit_text, unit = split_unit(header)
    if unit_row.strip():
        bare = unit_row.strip().strip("()[]").strip()
        if row_unit := parse_unit(bare):
            unit_text, unit = bare, row_unit
    name_words = words(name)
    angular = any(_spells(w, ANGULAR) for w in name_words) or bool(unit and unit.angular)
    derived = any(w.startswith(DERIVED) for w in name_words)
    other = any(w in OTHERS for w in name_words) or (
        unit is not None and unit.si in ("Hz", "degC", "K", "Pa", "%")
    )
    quantity = next((q for q, stems in WORDS if any(_spells(w, stems) for w in name_words)), None)
    strength = 3
    if unit is not None and unit.quantity is not None and not (quantity and unit.quantity == "time"):
        if quantity != unit.quantity:
            strength = 2 if quantity is None and _letter(name_words) != unit.quantity else 3
        quantity = unit.quantity
    elif quantity is None and unit is None:
        quantity, strength = _letter(name_words), 1
    if quantity is None or other:
        return Meaning(None, 0, unit, unit_text, angular, derived, other)
    if unit is not None and unit.quantity is not None and unit.quantity != quantity:
        unit, unit_text = None, ""
    return Meaning(quantity, strength, unit, unit_text, angular, derived, other)
