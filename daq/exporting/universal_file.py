"""Universal file: one data set 58 a channel, in binary doubles, through pyuff."""

import tempfile
import warnings
from pathlib import Path

import pyuff

from daq.exporting.csv_table import one_line
from daq.exporting.exported import Exported

QUANTITIES = {"displacement": 8, "velocity": 11, "acceleration": 12, "force": 13}
_TIME = 17
_LINE = 80
_EVEN = 1e-9
_ROTATION = ("rad",)


def encode(exported: Exported) -> bytes:
    """Return the data sets: function type 1 (time response), abscissa in s, ordinate in its SI unit.

    Samples that were lost are left out, for the format has no sign for them; the abscissa is even where none was lost
    and where six digits, as the format has them, give the sampling interval. The five lines of text
    that a set has hold the channel's name, the session's facts and the sensor.
    """
    recording = exported.recording
    step = 1.0 / recording.rate
    kept = recording.valid
    even = bool(kept.all()) and abs(float(f"{step:.5e}") - step) < _EVEN * step
    facts = [one_line(f"{name}: {fact}") for name, fact in exported.facts.items()]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sets.uff"
        file = pyuff.UFF(str(path))
        for number, (channel, name) in enumerate(zip(recording.channels, exported.names, strict=True), 1):
            turns = channel.unit.startswith(_ROTATION)
            texts = [name, *facts[:3], one_line(channel.sensor)] + [""] * 5
            data = {
                "type": 58, "binary": 1, "func_type": 1, "rsp_node": number, "rsp_dir": 4 if turns else 1,
                "ref_node": 0, "ref_dir": 0, "abscissa_spacing": int(even), "orddenom_spec_data_type": 0,
                "abscissa_spec_data_type": _TIME, "abscissa_axis_units_lab": "s",
                "ordinate_spec_data_type": QUANTITIES.get(channel.quantity, 0),
                "ordinate_axis_units_lab": channel.unit,
                "x": exported.time[kept], "data": recording.samples[number - 1][kept],
                **{f"id{i + 1}": text[:_LINE] or "NONE" for i, text in enumerate(texts[:5])},
            }  # fmt: skip
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ResourceWarning)  # pyuff leaves its file to the collector
                file.write_sets(data, "add")
        return path.read_bytes()
