"""The map of the missing force: stained where the model is wrong, within the noise where it is right."""

import csv
import io
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from daq.exporting import encode
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.misfit_errors import with_misfit_errors
from identify.formatting import SPACE, with_error
from identify.model.model import Term, base_model
from station.operations.examples import open_example
from station.operations.exporting import fitted_samples
from station.results.documents import Errors
from station.results.ladder import KeptStep
from station.results.models import model_file
from station.results.sessions import open_session
from station.settings import Settings
from station.story.engineering_values import Weighing
from station.story.preparation import prepare_session
from station.workbench.frames import frame_of, stage_of

DATA = Path(__file__).resolve().parent.parent / "data"
HIDDEN = {"release_14": "cubic_stiffness", "release_07": "offset_drift"}
"""What another program has hidden in these, see truth.json beside them."""


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """Return the releases, ready to be fitted."""
    settings = Settings(sessions=tmp_path_factory.mktemp("frames") / "sessions")
    files = [DATA / "hidden" / f"{name}.csv" for name in HIDDEN] + [DATA / "release_24.csv"]
    sessions = [open_session(str(file), settings.sessions) for file in files]
    return {session.folder.name: prepare_session(session, settings) for session in sessions}


def fitted(prepared, *added):
    model = base_model()
    for name in added:
        effect = find_effect(name)
        held = dict(effect.variants[0]) if effect.variants else {}
        if not hasattr(effect, "inner"):
            held = {"channel": "displacement"}  # its drift of 0.1 mm/s, see truth.json
        model = model.plus(Term(effect, held))
    return fit_baseline((prepared,), model).fit


def stain(frame):
    """Return the mean square of the missing force in units of its standard error: 1 where noise alone is left."""
    return float(np.mean((np.array(frame["force"]) / np.array(frame["force_std"])) ** 2))


def test_a_model_that_lacks_nothing_leaves_noise_in_every_cell(prepared):
    fit = fitted(prepared["release_24"])
    frame = frame_of(prepared["release_24"], fit)
    # the mean of n squares of unit normals has a standard error of sqrt(2/n), 0.15 with some 90 cells
    assert abs(stain(frame) - 1.0) < 0.6
    assert len(frame["force"]) == len(frame["cells"])


def test_the_noise_beside_a_residual_is_that_by_which_it_is_judged_coloured_or_not(tmp_path):
    """The ship's roll is one channel, whose noise is a random walk: its white part is a thousandth of it."""
    release = prepare_session(open_example("ship_roll", tmp_path), Settings())
    fit = fitted(release)
    frame = frame_of(release, fit)
    left = np.array(frame["left"][0], dtype=float)
    assert np.sqrt(np.nanmean(left**2)) / frame["noise"][0] == pytest.approx(np.sqrt(fit.reduced), rel=0.02)


@pytest.mark.parametrize(("name", "hidden"), HIDDEN.items())
def test_the_hidden_effect_bleaches_the_map_whether_it_is_a_force_or_a_fault_of_a_sensor(
    prepared, name, hidden
):
    usual, right = fitted(prepared[name]), fitted(prepared[name], hidden)
    assert stain(frame_of(prepared[name], usual)) > 4.0
    assert stain(frame_of(prepared[name], right)) < 1.5


def test_the_cells_of_the_map_lie_on_its_axes_and_hold_the_motion(prepared):
    release = prepared["release_14"]
    fit = fitted(release)
    frame, largest = frame_of(release, fit), stage_of(release, fit)["largest"]
    left, right, low, high = np.array(frame["cells"]).T
    assert np.all((left < right) & (low < high))
    assert np.all(np.abs([left, right]) <= 1.04 * largest["u"])  # the page leaves so much room around them
    assert np.all(np.abs([low, high]) <= 1.04 * largest["v"])
    u, v = 1e3 * release.motion.displacement[:, None], release.motion.velocity[:, None]
    inside = (u > left) & (u < right) & (v > low) & (v < high)
    assert inside.sum(axis=1).max() == 1
    assert inside.any(axis=1).mean() > 0.95


def test_another_mass_is_another_stage_so_that_no_tab_keeps_forces_of_the_old_one(prepared):
    release = prepared["release_14"]
    fit = fitted(release)
    assert stage_of(replace(release, mass=2.0), fit) != stage_of(replace(release, mass=3.0), fit)


def test_the_exported_samples_are_written_as_station_export_does_and_the_residual_is_what_the_model_leaves(
    prepared, tmp_path
):
    release = prepared["release_14"]
    fit = fitted(release)
    session = open_session(str(DATA / "hidden" / "release_14.csv"), tmp_path / "sessions")
    stated = model_file(with_misfit_errors(fit))
    top = KeptStep(model=stated, error=Errors(), floor_percent=None, at_floor=False, nuisances={})
    ladder = SimpleNamespace(top=top)
    refinement = SimpleNamespace(session=session, prepared=release, ladder=ladder, weighing=Weighing(2.0))
    text = encode(fitted_samples(refinement, fit), "csv").decode()
    head, *rows = csv.reader(line for line in io.StringIO(text) if not line.startswith("#"))
    assert head[:5] == [
        "time [s]", "time_since_release [s]", "displacement_aligned [m]", "velocity_aligned [m/s]",
        "acceleration_aligned [m/s^2]",
    ]  # fmt: skip
    assert len(rows) == len(release.window)
    read, model, residual = (
        head.index(f"acceleration_{what} [m/s^2]") for what in ("read", "model", "residual")
    )
    for row in rows[200:900:100]:
        assert float(row[read]) - float(row[model]) == pytest.approx(float(row[residual]), abs=1e-7)
    assert f"# session: {session.folder.name}\n" in text
    assert "# model: linear_stiffness + coulomb_friction + viscous_damping\n" in text
    k = stated.parameters["linear_stiffness.k"]
    assert k.std > 5.0 * fit.values["linear_stiffness.k"].std  # the model lacks a force
    said = with_error(2.0 * k.value, 2.0 * k.std).replace(SPACE, " ")
    assert f"# fitted linear_stiffness.k: {said} N/m\n" in text
    assert re.search(r"# at the start, velocity: \S+ m/s\n", text)
