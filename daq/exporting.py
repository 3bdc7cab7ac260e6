"""Recordings for other programs: the formats, by name and by a file's ending, that their own libraries read back.

A format's library is imported where the format is asked for: not all of them are installed everywhere.
"""

import csv
import io
import json
import re
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from daq.errors import OperatorError
from daq.plain_text import distinct
from daq.recording import Array, Channel, Recording

NUMBERS = ("calibration_uncertainty", "resolution", "low", "high")
"""What is known of a channel in numbers."""
TOPIC = "/samples"
"""The topic of the messages in an MCAP file."""
QUANTITIES = {"displacement": 8, "velocity": 11, "acceleration": 12, "force": 13}
TIME, LINE, EVEN = 17, 80, 1e-9
"""Of a universal file: codes of quantities, that of time, the length of a line of text, how even an abscissa is."""


@dataclass(frozen=True, eq=False)
class Exported:
    """A recording with what is known of it: `facts` are short texts by name (session, operator, mass, lag ...)."""

    recording: Recording
    facts: dict[str, str] = field(default_factory=dict)

    @property
    def time(self) -> Array:
        """Time of each sample since the first, shape (n,), s."""
        return np.arange(len(self.recording.valid)) / self.recording.rate

    @property
    def samples(self) -> Array:
        """The samples, shape (channels, n), in SI units; NaN where they were lost."""
        return np.asarray(np.where(self.recording.valid, self.recording.samples, np.nan))

    @cached_property
    def channels(self) -> dict[str, Channel]:
        """The channels, each by a name that is unlike the others, and that every format takes as a variable's name.

        The first channel of a quantity, which identification uses, has the quantity's name.
        """
        plain = (
            _identifier(c.name) if c.quantity == "other" else c.quantity for c in self.recording.channels
        )
        names = distinct(plain, "_", taken=("time", "valid"))
        return dict(zip(names, self.recording.channels, strict=True))

    @property
    def all_facts(self) -> dict[str, str]:
        """Facts of the recording itself, then those that were given."""
        recording = self.recording
        own = {"rate_hz": f"{recording.rate!r}"}
        if recording.rate_std is not None:
            own["rate_std_hz"] = f"{recording.rate_std!r}"
        own["samples_lost"] = str(int((~recording.valid).sum()))
        return own | self.facts

    def channel_facts(self, channel: Channel) -> dict[str, str]:
        """Describe a channel and its calibration in short texts, by name."""
        known = {
            "quantity": channel.quantity,
            "unit": channel.unit,
            "recorded_as": channel.name,
            "sensor": channel.sensor,
        }
        known |= {name: repr(value) for name in NUMBERS if (value := getattr(channel, name)) is not None}
        return {name: text for name, text in known.items() if text}


def _identifier(text: str) -> str:
    plain = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")[:24].lower()
    return plain if plain[:1].isalpha() else f"channel_{plain}".rstrip("_")


def to_csv(exported: Exported) -> bytes:
    """Return comment lines with what is known, a line of names with units, and a line a sample, as UTF-8.

    Numbers have as many digits as it takes to read the same ones back.
    """
    text = io.StringIO()
    for name, fact in exported.all_facts.items():
        text.write(f"# {name}: {_one_line(fact)}\n")
    for name, channel in exported.channels.items():
        known = exported.channel_facts(channel)
        text.write(f"# {name}: " + ", ".join(f"{k} {_one_line(v)}" for k, v in known.items()) + "\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        ["time [s]", *(f"{name} [{channel.unit}]" for name, channel in exported.channels.items())]
    )
    columns = [[repr(value) for value in exported.time.tolist()]]
    columns += [["" if v != v else repr(v) for v in row.tolist()] for row in exported.samples]
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode()


def to_matlab(exported: Exported) -> bytes:
    """Return a .mat file of version 5: time, one variable a channel, valid, rate, units, facts, calibration."""
    from scipy.io import savemat

    columns = dict(zip(exported.channels, exported.samples, strict=True))
    file: Any = io.BytesIO()  # as scipy documents; its stubs know paths only
    savemat(
        file,
        {
            "time": exported.time[:, None],
            **{name: values[:, None] for name, values in columns.items()},
            "valid": exported.recording.valid[:, None],
            "rate": np.array([[exported.recording.rate]]),
            "units": {"time": "s"} | {name: channel.unit for name, channel in exported.channels.items()},
            "calibration": {name: exported.channel_facts(c) for name, c in exported.channels.items()},
            "facts": exported.all_facts,
        },
        long_field_names=True,
        do_compression=True,
    )
    return bytes(file.getvalue())


def to_universal_file(exported: Exported) -> bytes:
    """Return a data set 58 a channel: binary doubles, function type 1 (time response), abscissa in s, ordinate in SI.

    Samples that were lost are left out, for the format has no sign for them; the abscissa is even where none was lost
    and where six digits, as the format has them, give the sampling interval. The five lines of text
    that a set has hold the channel's name, the session's facts and the sensor.
    """
    import pyuff

    recording = exported.recording
    step = 1.0 / recording.rate
    kept = recording.valid
    even = bool(kept.all()) and abs(float(f"{step:.5e}") - step) < EVEN * step
    facts = [_one_line(f"{name}: {fact}") for name, fact in exported.facts.items()]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sets.uff"
        file = pyuff.UFF(str(path))
        for number, (name, channel) in enumerate(exported.channels.items(), 1):
            turns = channel.unit.startswith("rad")
            texts = [name, *facts[:3], _one_line(channel.sensor)] + [""] * 5
            data = {
                "type": 58, "binary": 1, "func_type": 1, "rsp_node": number, "rsp_dir": 4 if turns else 1,
                "ref_node": 0, "ref_dir": 0, "abscissa_spacing": int(even), "orddenom_spec_data_type": 0,
                "abscissa_spec_data_type": TIME, "abscissa_axis_units_lab": "s",
                "ordinate_spec_data_type": QUANTITIES.get(channel.quantity, 0),
                "ordinate_axis_units_lab": channel.unit,
                "x": exported.time[kept], "data": recording.samples[number - 1][kept],
                **{f"id{i + 1}": text[:LINE] or "NONE" for i, text in enumerate(texts[:5])},
            }  # fmt: skip
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ResourceWarning)  # pyuff leaves its file to the collector
                file.write_sets(data, "add")
        return path.read_bytes()


def to_hdf5(exported: Exported) -> bytes:
    """Return the file: time, one data set a channel with time as its scale, valid."""
    import h5py

    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file.attrs.update(exported.all_facts)
        time = file.create_dataset("time", data=exported.time)
        time.attrs["unit"] = "s"
        time.make_scale("time")
        file.create_dataset("valid", data=exported.recording.valid)
        for (name, channel), values in zip(exported.channels.items(), exported.samples, strict=True):
            column = file.create_dataset(name, data=values)
            column.attrs.update(exported.channel_facts(channel))
            column.dims[0].attach_scale(time)
    return content.getvalue()


def to_parquet(exported: Exported) -> bytes:
    """Return the file: time, one column a channel, valid; units and calibration are in each field's metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields = [pa.field("time", pa.float64(), metadata={"unit": "s"})]
    fields += [
        pa.field(name, pa.float64(), metadata=exported.channel_facts(channel))
        for name, channel in exported.channels.items()
    ]
    fields.append(pa.field("valid", pa.bool_()))
    table = pa.table(
        [exported.time, *exported.samples, exported.recording.valid],
        schema=pa.schema(fields, metadata=exported.all_facts),
    )
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    return bytes(sink.getvalue().to_pybytes())


def to_mcap(exported: Exported) -> bytes:
    """Return a log with a message of JSON a sample; times are ns since the first sample, a reading that was lost is null."""
    from mcap.writer import Writer

    recording = exported.recording
    numbers: dict[str, Any] = {"type": ["number", "null"]}
    properties: dict[str, Any] = {"time": {"type": "number", "description": "s"}}
    properties |= {name: numbers | {"description": one.unit} for name, one in exported.channels.items()}
    schema = {"type": "object", "properties": properties}
    content = io.BytesIO()
    writer = Writer(content)
    writer.start(profile="", library="free-decay-station")
    kind = writer.register_schema("free_decay.Sample", "jsonschema", json.dumps(schema).encode())
    topic = writer.register_channel(TOPIC, "json", kind)
    columns = [row.tolist() for row in exported.samples]
    for i, time in enumerate(exported.time.tolist()):
        values = {n: None if c[i] != c[i] else c[i] for n, c in zip(exported.channels, columns, strict=True)}
        stamp = round(i * 1e9 / recording.rate)
        data = json.dumps({"time": time, **values}).encode()
        writer.add_message(topic, log_time=stamp, publish_time=stamp, data=data, sequence=i)
    writer.add_metadata("recording", exported.all_facts)
    for name, channel in exported.channels.items():
        writer.add_metadata(name, exported.channel_facts(channel))
    writer.finish()
    return content.getvalue()


def _one_line(text: str) -> str:
    """Return a text without line breaks and other control characters."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


FORMATS: dict[str, tuple[str, Callable[[Exported], bytes]]] = {
    "csv": (".csv", to_csv),
    "mat": (".mat", to_matlab),
    "uff": (".uff", to_universal_file),
    "hdf5": (".h5", to_hdf5),
    "parquet": (".parquet", to_parquet),
    "mcap": (".mcap", to_mcap),
}
"""Ending and encoder of each format."""
MORE_ENDINGS = {".hdf5": "hdf5", ".unv": "uff", ".txt": "csv"}


def form_of(file: Path) -> str | None:
    """Return the format that the ending of a file's name stands for; None where it stands for none."""
    ending = file.suffix.lower()
    by_ending = {its: name for name, (its, _) in FORMATS.items()} | MORE_ENDINGS
    return by_ending.get(ending)


def encode(exported: Exported, form: str) -> bytes:
    """Return a file's content in one of FORMATS. Raises OperatorError where the format's library is not installed."""
    try:
        return FORMATS[form][1](exported)
    except ModuleNotFoundError as missing:
        raise OperatorError(
            f"the format {form} needs the package {missing.name}, which is not installed; "
            "install it with: pip install 'free-decay-station[export]'"
        ) from missing
