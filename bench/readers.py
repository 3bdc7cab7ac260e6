"""Every reader of files, the valid files that fuzzing starts from, and what a reader may say of a bad one."""

import gc
import json
import struct
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from daq.errors import StationError
from daq.importing import ImportOptions, read_file, read_recipe
from daq.manifest import read_manifest, verify
from daq.port_names import fault_of
from daq.raw_log import MAGIC, Kind, Record, pack, unpack
from daq.recording import Channel, Recording
from daq.session import Session, list_sessions, recover
from daq.sources.text_lines import LineCutter, header_of, parse_line
from identify.effects.library import LIBRARY
from identify.effects.user import parse_effect
from identify.model.model import base_model
from station.exits import Problem
from station.results.diagnosis_document import SuspectDocument, read_diagnosis, refused_document
from station.results.ladder import read_ladder
from station.results.models import ModelFile, known_model, read_model
from station.settings import load_settings

LONGEST = 2000


@dataclass(frozen=True)
class Reader:
    """`read(data, folder)` gives one file's bytes to the station; `refusals` are what it may raise."""

    name: str
    read: Callable[[bytes, Path], object]
    seeds: tuple[bytes, ...]
    refusals: tuple[type[Exception], ...] = (StationError, Problem)


def attempt(reader: Reader, data: bytes, folder: Path) -> bool:
    """Read once; whether the file was taken. AssertionError when a refusal is no sentence, whatever else escapes."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            reader.read(data, folder)
        except reader.refusals as refusal:
            said = str(refusal)
            if not 0 < len(said.strip()) < LONGEST:
                raise AssertionError(f"{type(refusal).__name__} says {len(said)} characters") from refusal
            return False
    return True


def session_of(folder: Path) -> Path:
    """A small sealed session, made once."""
    made = folder / "sessions" / "s"
    if not made.exists():
        t = np.arange(300) / 256.0
        samples = np.vstack([0.02 * np.cos(25 * t), -12.5 * np.cos(25 * t)])
        channels = (Channel("u", "displacement", "m"), Channel("a", "acceleration", "m/s^2"))
        Session.create_imported(made, Recording(256.0, channels, samples, np.ones(300, dtype=bool)), None)
    return made


def _replacing(name: str, use: Callable[[Path], object]) -> Callable[[bytes, Path], object]:
    """A reader of one file of a session; the file is put back afterwards."""

    def read(data: bytes, folder: Path) -> object:
        session = session_of(folder)
        kept = {file: file.read_bytes() for file in session.rglob("*") if file.is_file()}
        try:
            (session / name).parent.mkdir(exist_ok=True)
            (session / name).write_bytes(data)
            return use(session)
        finally:
            for file in session.rglob("*"):
                if file.is_file() and file not in kept:
                    file.unlink()
            for file, content in kept.items():
                if not file.exists() or file.read_bytes() != content:
                    file.write_bytes(content)

    return read


def _use_info(session: Path) -> None:
    list_sessions(session.parent)
    opened = Session.open(session)
    opened.recording()


def _use_manifest(session: Path) -> None:
    verify(session)
    read_manifest(session)


def _use_raw_log(session: Path) -> None:
    verify(session)
    opened = Session.open(session)
    try:
        opened.recording()
    finally:
        (session / "manifest.json").unlink()
        recover(session)


def raw_log_of(data: bytes) -> bytes:
    """A raw log with sound checksums around arbitrary content: kind, length (2 bytes) and payload of each record."""
    import zlib

    from cobs import cobs

    out, at, sequence = [MAGIC], 0, 0
    while at + 3 <= len(data) and sequence < 200:
        kind, (length,) = data[at] % 4, struct.unpack_from("<H", data, at + 1)
        payload = data[at + 3 : at + 3 + length % 1024]
        at += 3 + length % 1024
        sequence += 1
        if kind == 0:
            payload = cobs.encode(payload + struct.pack("<I", zlib.crc32(payload))) + b"\0"
        out.append(pack(Record(Kind(max(kind, 1)), float(sequence), payload)))
    return b"".join(out)


def plain_of(log: bytes) -> bytes:
    """The content from which `raw_log_of` makes this log again, frame by frame."""
    from cobs import cobs

    out = []
    for record in unpack(log).records:
        if record.kind is Kind.RECEIVED:
            for piece in record.payload.split(b"\0"):
                if piece:
                    body = cobs.decode(piece)[:-4]
                    out.append(struct.pack("<BH", 4, len(body)) + body)
        else:
            out.append(struct.pack("<BH", record.kind, len(record.payload)) + record.payload)
    return b"".join(out)


def _named(name: str, use: Callable[[Path], object]) -> Callable[[bytes, Path], object]:
    def read(data: bytes, folder: Path) -> object:
        file = folder / name
        file.write_bytes(data)
        return use(file)

    return read


def _lines(data: bytes) -> None:
    for line in LineCutter().feed(data):
        parse_line(line)
        header_of(line)


def _expression(data: bytes, folder: Path) -> object:
    return parse_effect(data.decode("utf-8", "surrogateescape"))


MODEL: dict[str, Any] = {
    "format": 1,
    "equation": "a + k*u = 0",
    "effects": [
        {
            "effect": "linear_stiffness",
            "held": {},
            "parameters": {"k": {"value": 614.0, "std": 0.1, "unit": "1/s^2"}},
        },
    ],
    "expressions": ["magnet = a*u/(1+(u/b)**2)"],
}
TEXT = b"time_s,displacement_m,acceleration_m_s2\n" + b"".join(
    b"%.6f,%.9g,%.9g\n" % (i / 100, 0.02 * np.cos(i / 5), -0.5 * np.cos(i / 5)) for i in range(40)
)
JSON = (
    json.dumps(
        {"time": [i / 100 for i in range(40)], "u": [np.cos(i / 5) for i in range(40)], "u units": "mm"}
    ).encode(),
    json.dumps([{"t": i / 100, "x": np.cos(i / 5)} for i in range(40)]).encode(),
)
RECIPE = (
    b"recipe = 1\nrate = 100.0\nparts = [{from = 1.0}]\nfields = [\n"
    b'  {name = "x", role = "displacement", unit = "0.5 mm", zero = "median", wraps = 360},\n]\n[dialect]\ndelimiter = ";"\n'
)
MONITOR = b"".join(
    b"13:05:23.%03d -> angle: %.2f deg x=%.3f\n" % (10 * i, np.cos(i / 5), i) for i in range(40)
)
SETTINGS = b"""sessions = "sessions"
[specimen]
operator = "Ada"
mass_kg = 21.36
[capture]
rate = 256.0
[identify]
stiffness_orders = [1, 3]
"""
EXPRESSIONS = (b"magnet = a*u/(1+(u/b)**2)", b"x = c*v*abs(v)", b"d = 2*sign(v)*exp(-(v/w)**2)")


def _use_diagnosis(session: Path) -> None:
    document = read_diagnosis(Session.open(session))
    for model in (
        () if document is None else (document.fitted, *(suspect.model for suspect in document.suspects))
    ):
        if model is not None:
            known_model(model, "the diagnosis", LIBRARY)


def _diagnosis() -> bytes:
    model = ModelFile.model_validate_json(json.dumps(MODEL))
    suspect = SuspectDocument(
        effect="magnet", title="", kind="physics", channel=None, error_after=1.0, evidence=20.0,
        parameters={}, confusable_with=[], plausible=True, claimed=True, model=model,
    )  # fmt: skip
    document = refused_document(("s",), base_model(), "too short")
    return document.model_copy(update={"fitted": model, "suspects": [suspect]}).model_dump_json().encode()


def _ladder() -> bytes:
    error = {"force_mse_percent": 0.1, "motion_percent": 0.2, "chi2": 1.0, "chi2_std": 0.1}
    step = {
        "added": "",
        "removed": "",
        "model": MODEL,
        "error": error,
        "floor_percent": 0.2,
        "at_floor": False,
        "nuisances": {"x": 1.0},
    }
    ladder = {
        "format": 1,
        "steps": [step],
        "present": 0,
        "stopped_because": "",
        "verdict": None,
    }
    return json.dumps(ladder).encode()


def _mat(folder: Path) -> tuple[bytes, ...]:
    from scipy.io import savemat

    t = np.arange(40) / 100
    made = []
    for i, options in enumerate(({"do_compression": True}, {}, {"format": "4"})):
        savemat(folder / f"seed{i}.mat", {"t": t, "u": np.cos(t), "fs": 100.0}, **options)
        made.append((folder / f"seed{i}.mat").read_bytes())
    return tuple(made)


def _uff(folder: Path) -> tuple[bytes, ...]:
    import pyuff

    t = np.arange(40) / 100
    made = []
    for binary in (0, 1):
        file = folder / f"seed{binary}.uff"
        file.unlink(missing_ok=True)
        trace = pyuff.prepare_58(
            binary=binary, func_type=1, ordinate_spec_data_type=8, abscissa_spacing=1, abscissa_min=0.0,
            abscissa_inc=0.01, num_pts=40, x=t, data=np.cos(t), rsp_node=1, rsp_dir=1, ref_node=1, ref_dir=1,
            id1="u", id2="", id3="", id4="", id5="", orddenom_spec_data_type=0, ordinate_axis_units_lab="m",
        )  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pyuff.UFF(str(file)).write_sets(trace, "add")
        gc.collect()  # pyuff leaves its file to the collector
        made.append(file.read_bytes())
    return tuple(made)


def readers(folder: Path) -> tuple[Reader, ...]:
    """Every reader; `folder` is where the seeds are made."""
    folder.mkdir(parents=True, exist_ok=True)
    session = session_of(folder)
    log = (session / "raw.log").read_bytes()
    return (
        Reader("session.json", _replacing("session.json", _use_info), ((session / "session.json").read_bytes(),)),
        Reader("manifest.json", _replacing("manifest.json", _use_manifest), ((session / "manifest.json").read_bytes(),)),
        Reader("raw.log", _replacing("raw.log", _use_raw_log), (log,)),
        Reader("raw.log, sound checksums", lambda d, f: _replacing("raw.log", _use_raw_log)(raw_log_of(d), f), (plain_of(log),)),
        Reader("model file", _named("model.json", read_model), (json.dumps(MODEL).encode(),)),
        Reader("ladder.json", _replacing("results/ladder.json", lambda s: read_ladder(Session.open(s))), (_ladder(),)),
        Reader(
            "diagnosis.json", _replacing("results/diagnosis.json", _use_diagnosis), (_diagnosis(),),
        ),
        Reader("station.toml", _named("station.toml", load_settings), (SETTINGS,)),
        Reader("CSV", _named("a.csv", read_file), (TEXT, TEXT.replace(b",", b";").replace(b".", b","))),
        Reader("CSV, resampled", _named("a.csv", lambda file: read_file(file, ImportOptions(resample=True))), (TEXT,)),
        Reader("recipe", _named("a.toml", read_recipe), (RECIPE,)),
        Reader("MATLAB", _named("a.mat", read_file), _mat(folder)),
        Reader("UFF58", _named("a.uff", read_file), _uff(folder)),
        Reader("JSON", _named("a.json", read_file), JSON),
        Reader("text of a monitor", _named("a.txt", read_file), (MONITOR, MONITOR.replace(b".", b","))),
        Reader("lines of a board", lambda data, _: _lines(data), (MONITOR, TEXT, b"x\n{\"t\": 1, \"u\": [1, 2]}\n")),
        Reader("port", lambda data, _: fault_of(data.decode("latin-1")), (b"rfc2217://host:1?timeout=1",)),
        Reader("expression", _expression, EXPRESSIONS, (ValueError,)),
    )  # fmt: skip
