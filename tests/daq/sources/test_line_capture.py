"""A board that prints lines, captured: the samples it printed, its lost lines as gaps, its bytes kept."""

import numpy as np
import pytest
from printing_board import RATE, PrintingBoard, as_csv, as_json, release

from daq.capture import CaptureSettings, capture
from daq.errors import BoardError, OperatorError, PortError
from daq.raw_log import Kind, read
from daq.sources import SourceBoard, line_source as line_source_module
from daq.sources.line_format import Sample, find_format, load_profile, save_profile
from daq.sources.line_source import LineSource
from daq.sources.open_source import LineOptions

SETTINGS = CaptureSettings(duration_s=4.0, rest_s=0.5, check_clock=False)
CSV = {
    "columns": {"time": 1, "displacement": 2, "acceleration": 3},
    "units": {"time": "ms", "displacement": "um", "acceleration": "m/s^2"},
}
JSON = {"columns": {"acceleration": "imu.2"}, "units": {"displacement": "mm", "acceleration": "m/s^2"}}


def source(board, **options):
    return LineSource(board, LineOptions(**options).decide, listen_s=0.0)


@pytest.fixture(scope="module")
def motion():
    return release()


def test_a_csv_board_is_recorded_as_it_printed(motion, tmp_path):
    displacement, acceleration, _ = motion
    board = SourceBoard(source(PrintingBoard(as_csv(displacement, acceleration), at_once=300), **CSV))
    assert "from the board's stamps" in board.description.remarks[0]
    session = capture(board, SETTINGS, tmp_path / "s")
    recording = session.recording()
    assert recording.valid.all()
    assert recording.rate == pytest.approx(RATE, rel=3e-4)
    found = recording.channel("displacement")
    at = int(np.argmin(np.abs(np.convolve(displacement, found[::-1], "valid") - found @ found)))
    np.testing.assert_allclose(found, displacement[at : at + len(found)], atol=6e-9)
    np.testing.assert_allclose(
        recording.channel("acceleration"), acceleration[at : at + len(found)], atol=6e-7
    )
    kept = b"".join(r.payload for r in read(tmp_path / "s" / "raw.log").records if r.kind is Kind.SOURCE)
    assert f",{1e6 * displacement[at + 100]:.2f},".encode() in kept, (
        "the board's own bytes are in the raw log"
    )
    assert session.verdict is not None
    assert session.verdict.grade.value == "OK"


def test_lost_lines_are_gaps_by_the_counter(motion, tmp_path):
    displacement, acceleration, _ = motion
    hole = set(range(1700, 1709))
    board = SourceBoard(
        source(PrintingBoard(as_json(displacement, acceleration), lose=hole), rate_hz=RATE, **JSON)
    )
    recording = capture(board, SETTINGS, tmp_path / "s").recording()
    assert [gap.count for gap in recording.gaps] == [9]
    assert (~recording.valid).sum() == 9
    found = recording.channel("displacement")
    good = recording.valid
    start = next(
        i for i in range(len(displacement)) if np.allclose(displacement[i : i + 50], found[:50], atol=1e-9)
    )
    np.testing.assert_allclose(found[good], displacement[start : start + len(found)][good], atol=1e-9)


def test_names_and_units_of_a_header_are_understood(motion):
    displacement, acceleration, _ = motion
    lines = as_csv(displacement, acceleration)
    header = "time [ms],position [um],acc [m/s^2]"
    found = source(PrintingBoard(["0,0,0", header, *lines]))
    channels = found.describe().channels
    assert [(c.name, c.quantity, c.unit) for c in channels] == [
        ("position [um]", "displacement", "m"),
        ("acc [m/s^2]", "acceleration", "m/s^2"),
    ]
    assert found.form.channels[0].scale == 1e-6
    assert found.form.clock.kind == "stamps"


def test_a_profile_is_kept_and_read_again(motion, tmp_path):
    displacement, acceleration, _ = motion
    form = source(PrintingBoard(as_csv(displacement, acceleration)), **CSV).form
    save_profile(form, "bench", tmp_path)
    assert load_profile("bench", tmp_path) == form
    with pytest.raises(OperatorError, match=r"no profile 'benhc'.*there: bench"):
        load_profile("benhc", tmp_path)
    (tmp_path / "bad.json").write_text('{"channels": []}')
    with pytest.raises(OperatorError, match="no profile of lines"):
        load_profile("bad", tmp_path)
    with pytest.raises(OperatorError, match="no name of a profile"):
        save_profile(form, "../up", tmp_path)


def test_without_names_the_operator_is_told_what_comes(motion):
    displacement, acceleration, _ = motion
    with pytest.raises(
        OperatorError, match=r"no column is known to be a motion; what comes is 1 \(.* to .*--column"
    ):
        source(PrintingBoard(as_csv(displacement, acceleration)))


def test_a_unit_that_is_not_known_is_asked_for(motion):
    displacement, acceleration, _ = motion
    with pytest.raises(
        OperatorError, match=r"the unit of column 'x' is not known; say it, as --unit displacement=mm"
    ):
        source(PrintingBoard(as_json(displacement, acceleration)))


def test_text_and_silence_are_refused_in_a_sentence(monkeypatch):
    monkeypatch.setattr(line_source_module, "QUIET_S", 0.05)
    with pytest.raises(BoardError, match=r"no lines of numbers, as 'ready"):
        source(PrintingBoard(["ready, press a key"] * 50))
    with pytest.raises(PortError, match="no line came"):
        source(PrintingBoard([]))


def test_a_line_without_counter_or_stamp_says_so(motion):
    _, acceleration, _ = motion
    board = PrintingBoard([f"a:{a:.5f}" for a in acceleration])
    found = source(board, units={"acceleration": "m/s^2"}, rate_hz=RATE)
    assert "lines that are lost are not noticed" in found.describe().remarks[0]
    assert "256 Hz as given" in found.describe().remarks[0]


@pytest.mark.parametrize(("per_second", "scale"), [(1.0, 1.0), (1e3, 1e-3), (1e6, 1e-6)])
def test_the_unit_of_stamps_is_found_from_the_arrival_of_lines(per_second, scale):
    n = np.arange(700)
    sample = Sample(
        columns={"1": np.floor(n / RATE * 1e3) * per_second / 1e3, "pos": np.sin(n / 9.0)},
        arrivals=5.0 + np.ceil(n / 16) * 16 / RATE,
    )
    form = find_format(sample, units={"displacement": "mm"})
    assert (form.clock.kind, form.clock.column, form.clock.scale) == ("stamps", "1", scale)


def test_a_column_that_counts_is_a_counter_and_no_time():
    n = np.arange(700)
    sample = Sample(columns={"i": 1.0 * (n % 256), "pos": np.sin(n / 9.0)}, arrivals=n / RATE)
    assert find_format(sample, units={"displacement": "mm"}).clock.kind == "counter"


def microseconds(displacement, acceleration, late=None):
    """Lines of whole microseconds, um and m/s^2; `late` (us) is by how much each is taken late."""
    late = np.zeros(len(displacement)) if late is None else late
    return [
        f"{int(1e6 * i / RATE + late[i])},{1e6 * d:.2f},{a:.6f}"
        for i, (d, a) in enumerate(zip(displacement, acceleration, strict=True))
    ]


IN_US = CSV | {"units": CSV["units"] | {"time": "us"}}


def test_every_32nd_line_1p8_ms_late_by_its_stamp_is_said(motion, tmp_path):
    displacement, acceleration, _ = motion
    late = 1800.0 * (np.arange(len(displacement)) % 32 == 5)
    board = SourceBoard(source(PrintingBoard(microseconds(displacement, acceleration, late)), **IN_US))
    session = capture(board, SETTINGS, tmp_path / "s")
    assert session.verdict.grade.value == "USABLE WITH GAPS"
    assert "samples were not taken at even times" in session.verdict.reasons[0]
    assert session.info.rate_std_hz == pytest.approx(1.8e-3 * RATE, rel=0.05)  # 1.8 ms within a second


@pytest.mark.parametrize(("lines", "options"), [(microseconds, IN_US), (as_json, JSON | {"rate_hz": RATE})])
def test_a_line_that_comes_twice_counts_once(motion, tmp_path, lines, options):
    displacement, acceleration, _ = motion
    printed = lines(displacement, acceleration)
    twice = [line for i, line in enumerate(printed) for line in [line] * (2 if i % 100 == 50 else 1)]
    once = capture(SourceBoard(source(PrintingBoard(printed), **options)), SETTINGS, tmp_path / "once")
    again = capture(SourceBoard(source(PrintingBoard(twice), **options)), SETTINGS, tmp_path / "twice")
    assert again.verdict.grade.value == "OK"
    assert again.recording().rate == pytest.approx(RATE, rel=1e-6)
    found, whole = again.recording().channel("displacement"), once.recording().channel("displacement")
    np.testing.assert_array_equal(found[256:], whole[256 : len(found)])


CLOCKED = {
    "columns": {"time": 1, "displacement": 2},
    "units": {"time": "ms", "displacement": "mm"},
}


def commas(values):
    """The lines of a board that prints one number with a decimal comma."""
    return [f"{20 + 1e3 * v:.4f}".replace(".", ",") for v in values]


def test_a_decimal_comma_is_asked_about_and_never_read_as_two_columns(motion):
    options = {"columns": {"displacement": 1}, "units": {"displacement": "mm"}, "rate_hz": RATE}
    with pytest.raises(OperatorError, match=r"'\d+,\d+' may be 1 with a decimal comma or 2 columns"):
        source(PrintingBoard(commas(motion[0])), **options)
    stamped = [f"{int(1000 * i / RATE)},{line}" for i, line in enumerate(commas(motion[0]))]
    with pytest.raises(OperatorError, match="may be 1 with a decimal comma or 2 columns"):
        source(PrintingBoard(stamped), **(options | CLOCKED))


def test_whole_numbers_that_are_columns_are_read_when_it_is_said(motion):
    lines = [f"{round(1e6 * d)},{i % 7}" for i, d in enumerate(motion[0])]
    columns = {"displacement": 1, "unused": 2}
    found = source(PrintingBoard(lines), columns=columns, units={"displacement": "um"}, rate_hz=RATE)
    assert [c.name for c in found.describe().channels] == ["displacement"]
    both = {"displacement": 1, "acceleration": 2}
    units = {"displacement": "um", "acceleration": "m/s^2"}
    assert len(source(PrintingBoard(lines), columns=both, units=units, rate_hz=RATE).describe().channels) == 2
