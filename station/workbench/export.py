"""Export: the aligned channels of a release, the present model and what it leaves, as CSV."""

import csv
import io

import numpy as np

from identify.fitting.fit import Fit
from identify.preprocessing.prepared_decay import PreparedDecay


def as_csv(prepared: PreparedDecay, fit: Fit) -> str:
    """Return one line a sample: time, each channel as fitted, the model's reading and what is left; lost readings are empty.

    Displacement and velocity of the motion on one clock (the lag corrected) stand first. SI units, named in the header.
    """
    window, motion = fit.windows[0], prepared.motion
    units = {
        "displacement": window.unit,
        "velocity": f"{window.unit}/s",
        "acceleration": f"{window.unit}/s^2",
    }
    head = ["time since release [s]"]
    columns = [window.clock]
    for name in ("displacement", "velocity", "acceleration"):
        head.append(f"{name} aligned [{units[name]}]")
        columns.append(np.asarray(getattr(motion, name)))
    for channel in window.channels:
        read = np.where(window.used[channel], window.readings[channel], np.nan)
        head += [f"{channel} {what} [{units[channel]}]" for what in ("read", "model", "residual")]
        columns += [read, fit.predicted[0][channel], read - fit.predicted[0][channel]]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    for line in zip(*(column.tolist() for column in columns), strict=True):
        writer.writerow(["" if value != value else f"{value:.9g}" for value in line])
    return out.getvalue()
