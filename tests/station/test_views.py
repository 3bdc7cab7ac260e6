"""The viewer's recordings, read back: every number shown is the number that was found."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader
from scipy.spatial import ConvexHull
from synthetic import LAG, MASS, OMEGA, RATE, VISCOUS, identification

from identify.fitting.model_error import ModelError
from identify.formatting import SPACE
from identify.model.model import base_model
from station.story.adequacy import Adequacy
from station.story.engineering_values import UNKNOWN
from station.story.pipeline import Identification
from station.text.identification_text import told
from station.views import identification_figures as figures, overlay, tabs
from station.views.palette import VIEWERS


@pytest.fixture(scope="module")
def result() -> Identification:
    return identification()


@pytest.fixture(scope="module")
def file(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("views") / "one.rrd"
    tabs.write(path, "one", result)
    return path


def column(file, path, name):
    """Return the values of one component of one entity, in the order in which they were logged."""
    values = []
    for chunk in RrdReader(file).stream().filter(content=path):
        batch = chunk.to_record_batch()
        for field in batch.schema.names:
            if field == name or field.endswith(f":{name}"):
                values += [
                    np.asarray(row, dtype=float) for row in batch.column(field).to_pylist() if row is not None
                ]
    return np.concatenate(values) if values else np.zeros(0)


def text(file, path):
    for chunk in RrdReader(file).stream().filter(content=path):
        batch = chunk.to_record_batch()
        for field in batch.schema.names:
            if field.endswith("TextDocument:text"):
                return batch.column(field).to_pylist()[0][0]
    return ""


def test_the_channels_are_shown_bit_for_bit_as_they_were_recorded(file, result):
    assert np.array_equal(
        column(file, "/capture/displacement", "Scalars:scalars"), result.decay.displacement * 1e3
    )
    assert np.array_equal(column(file, "/capture/acceleration", "Scalars:scalars"), result.decay.acceleration)


@pytest.mark.usefixtures("unrendered")
def test_lost_samples_leave_a_hole_and_no_curve(result, tmp_path):
    valid = np.ones(len(result.decay), dtype=bool)
    valid[400:420] = False
    holed = replace(result, decay=result.decay.with_(valid=valid))
    path = tmp_path / "holed.rrd"
    tabs.write(path, "holed", holed)
    shown = column(path, "/capture/displacement", "Scalars:scalars")
    assert np.array_equal(np.isnan(shown), ~valid)
    assert "20 samples, marked" in text(path, "/capture/facts")


def test_the_lag_is_told_with_its_error_and_what_it_would_have_done(file):
    told = text(file, "/alignment/text")
    assert "late by 1300.0 ± 3.1 µs" in told.replace(SPACE, " ")
    assert f"{MASS * (VISCOUS + OMEGA**2 * LAG):.4g} N s/m" in told.replace(SPACE, " ")


def test_the_overlay_differentiates_a_known_motion_rightly(result):
    time = np.arange(4096) / RATE
    swing = 0.02 * np.sin(OMEGA * time)
    late = 0.02 * np.sin(OMEGA * (time - LAG))
    decay = result.decay.with_(displacement=late, acceleration=-(OMEGA**2) * swing)
    known = replace(result, decay=decay, aligned=decay.with_(displacement=swing))
    shown = overlay.overlay(known)
    # The Gaussian is cut at 7 standard deviations and sampled: a part in a million of 12 m/s^2.
    assert np.abs(shown.acceleration - shown.after).max() < 1.2e-5
    amplitude = 0.02 * OMEGA**2 * np.exp(-0.5 * (2 * np.pi * 0.05) ** 2)
    expected = amplitude * OMEGA * LAG  # a small lag leaves amplitude x angular frequency x lag
    assert np.abs(shown.acceleration - shown.before).max() == pytest.approx(expected, rel=0.02)


def test_the_envelope_the_fit_and_the_frequency_are_those_that_were_found(file, result):
    found = result.wavelet
    assert np.array_equal(column(file, "/wavelet/envelope/measured", "Scalars:scalars"), found.envelope * 1e3)
    assert np.array_equal(
        column(file, "/wavelet/envelope/model", "Scalars:scalars"), found.envelope_fit * 1e3
    )
    shown = column(file, "/wavelet/frequency", "Scalars:scalars")
    assert np.array_equal(shown[found.trusted], found.frequency[found.trusted])
    assert np.isnan(shown[~found.trusted]).all()
    left, *_ = figures.orders(result).axes
    assert np.array_equal(left.lines[0].get_ydata(), found.mse_percent_by_order)
    (ridge, fit) = figures.backbone(found, "m", VIEWERS[True]).axes[0].lines
    every = found.trusted.sum() // figures.MOST_DOTS or 1
    assert np.array_equal(ridge.get_ydata(), 1e3 * found.envelope[found.trusted][::every])
    assert np.array_equal(fit.get_xdata(), found.frequency_fit[found.trusted][::every])
    ridge = figures.scalogram(found, VIEWERS[True]).axes[0].lines[1]
    assert np.array_equal(ridge.get_ydata()[found.trusted], found.frequency[found.trusted])


def test_the_surface_the_sections_and_the_significance_are_those_that_were_found(file, result):
    found = result.restoring_force
    for part, force in (("fit", found.force_fit), ("measured", found.force)):
        component = "Mesh3D:vertex_positions" if part == "fit" else "Points3D:positions"
        shown = column(file, f"/restoring_force/surface/{part}", component).reshape(-1, 3)
        for placed, values in zip(shown.T, (found.displacement, found.velocity, force), strict=True):
            reach = np.abs(values).max() / np.abs(placed).max()
            # A single-precision number; the cube ends where the measurement or the fit does.
            assert np.allclose(placed * reach, values, rtol=1e-5, atol=1e-6 * reach)
            assert 0.9 < np.abs(placed).max() <= 1.0 + 1e-6
    triangles = column(file, "/restoring_force/surface/fit", "Mesh3D:triangle_indices").reshape(-1, 3)
    corners = np.column_stack([found.displacement, found.velocity])[triangles.astype(int)]
    sides = np.diff(corners, axis=1)
    covered = 0.5 * np.abs(np.linalg.det(sides)).sum()
    assert covered == pytest.approx(ConvexHull(corners.reshape(-1, 2)).volume, rel=1e-6)
    cuts = figures.sections(found, UNKNOWN).axes
    for axis, cut in zip(cuts, (found.section_zero_velocity, found.section_zero_displacement), strict=True):
        every = len(cut.force) // figures.MOST_DOTS or 1
        assert np.array_equal(axis.lines[0].get_ydata(), cut.force[::every])
        assert any(np.array_equal(line.get_ydata(), cut.fit) for line in axis.lines)
    *_, orders, bars = figures.orders(result).axes
    assert np.array_equal(orders.lines[0].get_ydata(), found.mse_percent_by_order)
    percent = [bar.get_width() for bar in bars.patches]
    assert np.allclose(percent, sorted(found.significance_percent.values(), reverse=True))


def test_the_results_are_the_table_and_both_reconstructions(file, result):
    told = text(file, "/results/table").replace(SPACE, " ")
    assert "13115.2 ± 2.1" in told
    assert "13114.90 ± 0.60" in told
    assert "N s/m" in told
    force, fit = (
        MASS * values for values in (result.restoring_force.force, result.restoring_force.force_fit)
    )
    assert np.array_equal(column(file, "/results/force/model", "Scalars:scalars"), fit)
    left = column(file, "/results/force_error", "Scalars:scalars")
    assert np.allclose(left, force - fit, rtol=1e-12)


def test_values_that_must_not_be_quoted_are_told_as_such_before_they_are_shown(result):
    poor = Adequacy(
        SimpleNamespace(model=base_model()), ModelError(11.8, 0.916, 8.0, 229.0, 0.05), adequate=False
    )
    found = told("one", replace(result, adequacy=poor))
    assert "0.916 % of the motion, 15.1 times the noise" in found.headline
    assert "do not quote" in found.headline
    (table,) = (part for part in found.brief if part.kind == "table")
    assert table.head[0] == "do not quote"


def test_a_method_that_refused_says_so_in_its_tab(result, tmp_path):
    why = {"wavelet": "too few cycles", "restoring_force": "too short", "alignment": "one channel"}
    nothing = dict.fromkeys(("wavelet", "restoring_force", "alignment"))
    refused = replace(result, refusals=why, **nothing)
    path = tmp_path / "refused.rrd"
    tabs.write(path, "refused", refused)
    assert "too few cycles" in text(path, "/wavelet/refusal")
    assert "too short" in text(path, "/restoring_force/refusal")
    assert "One channel" in text(path, "/alignment/text")


@pytest.mark.usefixtures("unrendered")
def test_an_acceleration_alone_is_shown_without_a_displacement(result, tmp_path):
    alone = result.decay.with_(displacement=None, noise_displacement=None)
    path = tmp_path / "alone.rrd"
    wavelet = replace(result.wavelet, channel="acceleration")
    one = replace(result, decay=alone, aligned=alone, alignment=None, wavelet=wavelet)
    tabs.write(path, "alone", one)
    assert np.array_equal(column(path, "/capture/acceleration", "Scalars:scalars"), alone.acceleration)
    assert len(column(path, "/capture/displacement", "Scalars:scalars")) == 0


@pytest.mark.usefixtures("unrendered")
def test_the_tabs_are_named_as_the_story_is_told(result):
    stream = rr.RecordingStream("tabs", send_properties=False)
    names = [tab(stream, VIEWERS[True], "one", result).name for tab in tabs.TABS]
    assert names == ["Capture", "Alignment", "Wavelet", "Restoring force", "Results"]
