"""MATLAB, format 5: one variable a channel, a column of doubles, and structures of units and facts."""

import io
from typing import Any

import numpy as np
from scipy.io import savemat

from daq.exporting.exported import Exported


def encode(exported: Exported) -> bytes:
    """Return a .mat file: time, one variable a channel, valid, rate, units, facts, calibration."""
    channels = exported.recording.channels
    columns = dict(zip(exported.names, exported.samples, strict=True))
    file: Any = io.BytesIO()  # as scipy documents; its stubs know paths only
    savemat(
        file,
        {
            "time": exported.time[:, None],
            **{name: values[:, None] for name, values in columns.items()},
            "valid": exported.recording.valid[:, None],
            "rate": np.array([[exported.recording.rate]]),
            "units": {"time": "s"} | {n: c.unit for n, c in zip(exported.names, channels, strict=True)},
            "calibration": {
                n: exported.channel_facts(c) for n, c in zip(exported.names, channels, strict=True)
            },
            "facts": exported.all_facts,
        },
        long_field_names=True,
        do_compression=True,
    )
    return bytes(file.getvalue())
