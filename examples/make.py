"""Makes the recordings of this folder: cuts the measured ones to what is needed and draws the simulated ones.

`python examples/make.py FOLDER` reads the measured recordings as they were published from FOLDER; without
FOLDER only the simulated ones are made. Nothing is rounded, scaled or filtered.
"""

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
SIMULATED = {
    "simulated_plain": (None, 0.0, 24),
    "simulated_stribeck": ("stribeck_friction", 0.01, 7),
    "simulated_drift": ("offset_drift", 0.01, 12),
}
"""What is hidden in each (for a sensor's fault, in one channel), its strength, and the seed."""


def simulated(name: str) -> str:
    """Return the text of a simulated recording: time (s), displacement (m), acceleration (m/s^2)."""
    from mocks.generate import draw

    sample = draw(*SIMULATED[name])
    time = np.arange(len(sample.displacement)) / sample.rate
    rows = zip(time, sample.displacement, sample.acceleration, strict=True)
    lines = [f"{t:.8f},{u:.8e},{a:.6f}" for t, u, a in rows]
    return "\n".join(["time_s,displacement_m,acceleration_m_s2", *lines, ""])


def lines_of(file: Path, first: int, count: int, columns: tuple[int, ...], delimiter: str) -> str:
    """Return `count` rows from row `first` (0: the first below the header) and some columns of a text table."""
    header, *rows = file.read_text(encoding="utf-8").splitlines()
    kept = [header, *rows[first : first + count]]
    cut = (delimiter.join(row.split(delimiter)[c] for c in columns) for row in kept)
    return "\n".join(cut) + "\n"


def cut_measured(published: Path) -> None:
    """Write the three measured recordings from those that were published."""
    from scipy.io import loadmat, savemat

    spring = lines_of(published / "spring_disc" / "release_1.csv", 0, 4000, (0, 1, 2, 3), ";")
    (HERE / "spring_disc.csv").write_text(spring, encoding="utf-8", newline="\n")
    roll = lines_of(published / "ship_roll" / "model_test_21337.csv", 1800, 5000, (0, 4), ",")
    (HERE / "ship_roll.csv").write_text(roll, encoding="utf-8", newline="\n")
    driven = loadmat(published / "silverbox" / "SNLS80mV.mat")
    part = slice(45056, 45056 + 4096)
    voltages = {name: driven[name][:, part] for name in ("V1", "V2")}
    savemat(HERE / "silverbox.mat", voltages, do_compression=True)


if __name__ == "__main__":
    for called in SIMULATED:
        (HERE / f"{called}.csv").write_text(simulated(called), encoding="utf-8", newline="\n")
    if len(sys.argv) > 1:
        cut_measured(Path(sys.argv[1]))
