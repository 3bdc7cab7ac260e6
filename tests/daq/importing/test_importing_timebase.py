"""Time stamps: even, uneven, doubled, missing, jumping, in other units."""

import math
from pathlib import Path

import numpy as np
import pytest
from import_files import OMEGA, load, refusal, said, swing, table

from daq.importing.reading import read_runs
from daq.importing.recipe import read_recipe
from daq.quality import judge

T, U, V, A = swing(400)
HEADER = "time_s,displacement_m"


def moved(stamps: np.ndarray) -> np.ndarray:
    return 0.02 * np.exp(-0.1 * stamps) * np.cos(OMEGA * stamps)


def test_milliseconds_are_read_from_the_header_or_guessed_and_reported(tmp_path: Path) -> None:
    for header, stamps in (("t_ms,x_m", T * 1e3), ("time,x_m", np.round(T * 1e3)), ("t (us),x_m", T * 1e6)):
        recording = load(tmp_path, table(header, stamps, U))
        assert recording.rate == pytest.approx(100.0)
    assert "milliseconds" in said(load(tmp_path, table("time,x_m", np.round(T * 1e3), U)))


def test_seconds_are_assumed_and_reported(tmp_path: Path) -> None:
    recording = load(tmp_path, table("time,x_m", T + 5.0, U))
    assert recording.rate == pytest.approx(100.0)
    assert "seconds were assumed" in said(recording)


def test_epoch_milliseconds_keep_their_steps(tmp_path: Path) -> None:
    recording = load(tmp_path, table("timestamp,x_m", 1_700_000_000_000 + np.round(T * 1e3), U, form="%.15g"))
    assert recording.rate == pytest.approx(100.0, rel=1e-9)


def test_dates_and_times_of_day_over_midnight_are_read(tmp_path: Path) -> None:
    seconds = 86_398.0 + T

    def clock(s: float) -> str:
        s %= 86_400.0
        return f"{int(s // 3600):02d}:{int(s // 60 % 60):02d}:{s % 60:06.3f}"

    rows = "\n".join(f"{clock(round(s, 3))},{u:.9g}" for s, u in zip(seconds, U, strict=True))
    recording = load(tmp_path, "Uhrzeit,Weg [m]\n" + rows)
    assert recording.rate == pytest.approx(100.0, rel=1e-6)
    assert "midnight" in said(recording)
    rows = "\n".join(f"2024-02-28T{clock(s)}Z;{u:.9g}".replace(".", ",") for s, u in zip(T, U, strict=True))
    recording = load(tmp_path, "Zeit;Weg [m]\n" + rows)
    assert recording.rate == pytest.approx(100.0, rel=1e-6)
    np.testing.assert_allclose(recording.samples[0], U, rtol=1e-8)


def test_readings_taken_at_uneven_stamps_are_put_on_an_even_clock(tmp_path: Path) -> None:
    jitter = np.random.default_rng(1).normal(0.0, 2e-4, T.size)
    recording = load(tmp_path, table(HEADER, T + jitter, moved(T + jitter)))
    assert recording.rate_std is not None
    assert abs(recording.rate - 100.0) < 5 * recording.rate_std
    line = np.polyval(np.polyfit(np.arange(T.size), T + jitter, 1), np.arange(T.size))
    stray = float(np.std(T + jitter - line)) * 1e3
    assert f"stray by {stray:.3g} ms rms" in said(recording)
    assert "cubic spline" in said(recording)
    inner = slice(3, -3)
    np.testing.assert_allclose(recording.samples[0][inner], moved(line)[inner], atol=1e-6)


def test_stamps_that_wander_slowly_are_believed_though_the_noise_hides_it_from_row_to_row(
    tmp_path: Path,
) -> None:
    noise = np.random.default_rng(5).normal(0.0, 2e-4, T.size)
    drifted = T + 1.5e-3 * np.sin(2.0 * np.pi * T / 2.5)
    recording = load(tmp_path, table(HEADER, drifted, moved(drifted) + noise))
    assert "cubic spline" in said(recording)
    line = np.polyval(np.polyfit(np.arange(T.size), drifted, 1), np.arange(T.size))
    assert np.std((recording.samples[0] - moved(line))[3:-3]) < 3e-4


def test_stamps_that_tell_when_a_row_arrived_leave_readings_on_their_even_clock(tmp_path: Path) -> None:
    late = np.random.default_rng(6).uniform(0.0, 4e-3, T.size)
    recording = load(tmp_path, table(HEADER, T + late, U))
    assert "smoother at even times" in said(recording)
    np.testing.assert_allclose(recording.samples[0], U, rtol=1e-7)


@pytest.mark.parametrize("readings", ["quick", "dropouts", "empty cells", "a long tail"])
def test_where_readings_are_rougher_shows_in_every_kind_of_record(tmp_path: Path, readings: str) -> None:
    """Nine readings a cycle; one reading in a hundred lost to 0; every fifth cell empty; a tenth of the record in motion."""
    random = np.random.default_rng(7)
    time = np.arange(4000) * 0.01
    late = random.uniform(0.0, 2e-3, time.size)
    x = 0.02 * np.cos((2.0 * np.pi * 11.0 if readings == "quick" else OMEGA) * time)
    x += random.normal(0.0, 2e-5, time.size)
    if readings == "dropouts":
        x[::100] = 0.0
    if readings == "empty cells":
        x[::5] = np.nan
    if readings == "a long tail":
        x *= np.where(time < 4.0, 1.0, 1e-3)
    recording = load(tmp_path, table(HEADER, time + late, x).replace("nan", ""))
    assert "smoother at even times" in said(recording)


def test_the_rates_standard_error_is_right_for_white_jitter(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    pulls = []
    for _ in range(40):
        recording = load(tmp_path, table(HEADER, T + random.normal(0.0, 3e-4, T.size), U))
        assert recording.rate_std is not None
        pulls.append((recording.rate - 100.0) / recording.rate_std)
    assert 0.7 < np.std(pulls) < 1.35  # 1 +- 3 / sqrt(2 * 40)


def test_resampling_when_asked_puts_the_samples_where_they_would_have_been(tmp_path: Path) -> None:
    jitter = np.random.default_rng(3).uniform(-2e-3, 2e-3, T.size)
    text = table(HEADER, T + jitter, moved(T + jitter))
    resampled = load(tmp_path, text, resample=True)
    fit = np.polyfit(np.arange(T.size), T + jitter, 1)  # where sample 0 of the even clock misconfiguration
    truth = moved(np.polyval(fit, np.arange(T.size)))
    inner = slice(3, -3)
    assert np.max(np.abs(moved(T + jitter) - truth)[inner]) > 1e-4
    # cubic spline: (w h)^4 / 384 of 20 mm is 2e-8 m at even knots, some tens of times more at uneven ones
    assert np.max(np.abs(resampled.samples[0] - truth)[inner]) < 1e-6
    assert "cubic spline" in said(resampled)


def test_stamps_too_uneven_for_a_clock_are_refused_unless_resampled(tmp_path: Path) -> None:
    stamps = np.sort(np.random.default_rng(4).uniform(0.0, 4.0, 400))
    stamps = np.unique(np.round(stamps, 6))
    text = table(HEADER, stamps, moved(stamps))
    assert "--resample" in refusal(tmp_path, text)
    assert load(tmp_path, text, resample=True).valid.mean() > 0.2


def test_rows_missing_by_their_stamps_become_marked_losses(tmp_path: Path) -> None:
    keep = np.ones(T.size, dtype=bool)
    keep[[50, 51, 52, 200]] = False
    recording = load(tmp_path, table(HEADER, T[keep], U[keep]))
    assert recording.samples.shape == (1, 400)
    assert np.flatnonzero(~recording.valid).tolist() == [50, 51, 52, 200]
    np.testing.assert_allclose(recording.samples[0][keep], U[keep], rtol=1e-8)
    assert [(g.first, g.count) for g in recording.gaps] == [(50, 3), (200, 1)]
    assert "4 samples are missing" in said(recording)
    assert "line 52" in said(recording)


def test_losses_stay_losses_when_resampled(tmp_path: Path) -> None:
    keep = np.ones(T.size, dtype=bool)
    keep[100:110] = False
    recording = load(tmp_path, table(HEADER, T[keep], U[keep]), resample=True)
    assert np.flatnonzero(~recording.valid).tolist() == list(range(100, 110))


def test_rows_written_twice_are_left_out(tmp_path: Path) -> None:
    rows = np.sort(np.concatenate((np.arange(400), [7, 7, 300])))
    recording = load(tmp_path, table(HEADER, T[rows], U[rows]))
    assert recording.samples.shape == (1, 400)
    assert "3 rows repeat" in said(recording)
    assert "line 10" in said(recording)


def test_stamps_coarser_than_the_sampling_are_kept_in_order(tmp_path: Path) -> None:
    t, u, _, _ = swing(4000, 2000.0)
    recording = load(tmp_path, table(HEADER, np.floor(t * 1000) / 1000, u))
    assert recording.samples.shape == (1, 4000)
    assert recording.rate == pytest.approx(2000.0, rel=1e-4)
    assert "coarser" in said(recording)


def test_a_few_rows_out_of_order_are_sorted(tmp_path: Path) -> None:
    order = np.arange(400)
    order[[30, 31]] = [31, 30]
    recording = load(tmp_path, table(HEADER, T[order], U[order]))
    np.testing.assert_allclose(recording.samples[0], U, rtol=1e-8)
    assert "out of order" in said(recording)


def test_a_file_whose_newest_row_comes_first_is_turned_round(tmp_path: Path) -> None:
    recording = load(tmp_path, table(HEADER, T[::-1], U[::-1]))
    np.testing.assert_allclose(recording.samples[0], U, rtol=1e-8)
    assert "the newest row comes first" in said(recording)


def test_a_clock_that_jumps_back_into_the_record_is_refused_with_its_line(tmp_path: Path) -> None:
    message = refusal(
        tmp_path, table(HEADER, np.concatenate((T[:200], T[40:240])), U)
    )  # into the record, not to its start
    assert "line 202, column 1" in message
    assert "jumps back" in message


def test_a_jump_ahead_that_would_fill_the_memory_is_refused(tmp_path: Path) -> None:
    stamps = T.copy()
    stamps[200:] += 1e9
    message = refusal(tmp_path, table(HEADER, stamps, U, form="%.15g"))
    assert "line 202" in message


def test_stamps_that_do_not_advance_are_refused(tmp_path: Path) -> None:
    assert "do not advance" in refusal(tmp_path, table(HEADER, np.zeros(400), U))


def test_a_few_rows_without_a_stamp_are_left_out(tmp_path: Path) -> None:
    lines = table(HEADER, T, U).splitlines()
    lines[10] = "," + lines[10].split(",")[1]
    recording = load(tmp_path, "\n".join(lines))
    assert np.flatnonzero(~recording.valid).tolist() == [9]
    assert "without a time stamp" in said(recording)


@pytest.mark.parametrize("step", [4.8e-225, 5e-324, 1e-150])
def test_stamps_that_hardly_advance_are_refused(tmp_path: Path, step: float) -> None:
    t = np.concatenate(([-step], np.zeros(7)))
    assert "do not advance" in refusal(tmp_path, table("time_s,displacement_m", t, U[:8], form="%.3g"))


@pytest.mark.parametrize("step", [1e-300, 1e-154, 1e-50])
def test_stamps_written_twice_that_hardly_advance_are_refused(tmp_path: Path, step: float) -> None:
    rows = "\n".join(f"{(i // 2) * step!r},{u:.9f}" for i, u in enumerate(U[:40]))
    assert refusal(tmp_path, f"time_s,displacement_m\n{rows}\n")


def in_blocks(rows: int, rate: float, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Return stamps of rows that a program read in blocks of 8 to 24, some ms late, and the rows' own times."""
    rng = np.random.default_rng(seed)
    at, stamps = np.arange(rows) / rate, np.empty(rows)
    first = 0
    while first < rows:
        last = min(first + int(rng.integers(8, 25)), rows)
        stamps[first:last] = round(at[last - 1] + rng.uniform(0.0, 0.01), 3)
        first = last
    return stamps, at


def test_for_rows_that_share_the_stamp_of_their_block_the_mean_rate_is_proposed_with_its_error(
    tmp_path: Path,
) -> None:
    stamps, at = in_blocks(2000, 250.0)
    text = table(HEADER, stamps, moved(at))
    assert "many are equal to the one before; if the rows were read evenly" in refusal(tmp_path, text)
    recording = load(tmp_path, text, accept=True)
    assert recording.samples.shape[1] == 2000
    assert recording.rate == pytest.approx(250.0, rel=2e-3)
    assert abs(recording.rate - 250.0) < 2.0 * recording.rate_std < 2.0


def test_blocks_that_follow_no_clock_are_refused(tmp_path: Path) -> None:
    stamps, at = in_blocks(600, 250.0)
    stopped = stamps + 3.0 * (at > 1.2)  # the logger stood still for 3 s
    assert "stray" in refusal(tmp_path, table(HEADER, stopped, moved(at)))


def changing() -> str:
    """Return 300 rows at 50 Hz and, after a gap, 60 at 7.5 Hz: a logger that saves room."""
    times = 7.3 + np.concatenate([np.arange(300) / 50.0, 6.4 + np.arange(60) / 7.5])
    return table(HEADER, times, np.exp(-0.3 * times) * np.cos(6.0 * times))


def test_after_a_gap_another_clock_is_asked_for_and_cut_off_by_its_times(tmp_path: Path) -> None:
    text = changing()
    assert "stray" in refusal(tmp_path, text)
    first, later = load(tmp_path, text, start=9.3, stop=13.3), load(tmp_path, text, start=19.0)
    assert first.rate == pytest.approx(50.0, rel=1e-6)
    assert first.samples.shape[1] == 200
    assert later.rate == pytest.approx(7.5, rel=1e-6)


def test_rows_that_the_operator_cuts_off_refuse_nothing(tmp_path: Path) -> None:
    """After 5 s the stamps jump back by 2.5 s, which only a recipe could explain."""
    t, x = np.arange(400) / 50.0, np.cos(np.arange(400) / 8.0)
    jumping = np.where(t < 5.0, t, t - 2.5)
    text = table("t (s),x (m),v (m/s)", jumping, x, np.gradient(x, t))
    assert "jumps back" in refusal(tmp_path, text)
    assert load(tmp_path, text, stop=2.4).samples.shape == (2, 121)


def test_stamps_at_which_the_readings_are_rough_are_left_out(tmp_path: Path) -> None:
    at = np.arange(400) / 10.0
    late = at + np.random.default_rng(7).exponential(0.2, 400)
    text = table(HEADER, np.sort(late), np.cos(2.0 * at))
    assert "smoother if they were read evenly" in refusal(tmp_path, text)
    assert load(tmp_path, text, accept=True).rate == pytest.approx(10.0, rel=0.01)


def test_a_clock_that_is_set_back_leaves_the_rows_in_their_order(tmp_path: Path) -> None:
    at = np.arange(500) / 50.0
    stamps = np.where(np.arange(500) < 270, at, at - 0.075)
    text = table(HEADER, stamps, np.cos(5.0 * at))
    assert "set back from 5.38 to 5.325, and the rows go on" in refusal(tmp_path, text)
    recording = load(tmp_path, text, accept=True)
    assert recording.samples[0].tolist() == pytest.approx(np.cos(5.0 * at).tolist(), abs=1e-6)
    assert recording.rate == pytest.approx(50.0, rel=1e-4)


def test_no_spline_is_drawn_through_stamps_that_are_mostly_equal(tmp_path: Path) -> None:
    """Five rows at each stamp, and the interval between stamps wanders: what was read when is not in the file."""
    steps = np.random.default_rng(5).uniform(0.05, 0.4, 60)
    times = np.repeat(np.cumsum(steps), 5)
    text = table(HEADER, times, np.cos(np.arange(300) / 9.0))
    for resample in (False, True):
        said_so = refusal(tmp_path, text, resample=resample)
        assert "equal to the one before" in said_so
        assert "--rate" in said_so
        assert "--resample" not in said_so


def test_a_part_without_rows_is_refused_with_the_times_there_are(tmp_path: Path) -> None:
    assert "go from 7.3 s to 21.5" in refusal(tmp_path, changing(), stop=3.0)


@pytest.mark.parametrize(("regular", "jitter"), [(True, 0.0), (False, 0.0), (False, 1e-3)])
def test_rows_that_repeat_the_last_reading_are_kept_and_told_by_the_verdict(
    tmp_path: Path, regular: bool, jitter: float
) -> None:
    """A sensor that is asked faster than it answers, or a tracker that finds its ball now and then."""
    times = np.arange(900) / 30.0
    new = np.diff(np.floor(19.7 * times), prepend=-1.0) > 0.0
    if not regular:
        new = np.random.default_rng(4).random(900) < 0.4
        new[0] = True
    measured = times[np.maximum.accumulate(np.where(new, np.arange(900), 0))]
    x = 40.0 * np.exp(-0.15 * measured) * np.cos(2 * np.pi * 1.1 * measured)
    stamps = times + jitter * np.random.default_rng(5).standard_normal(900)
    text = table("t (s),x (mm),y (mm)", stamps, np.round(x, 3), np.zeros(900))
    lines = text.splitlines()
    lines[400] = lines[400].split(",")[0] + ",,0"
    recording = load(tmp_path, "\n".join(lines), columns={"displacement": "x (mm)"})
    assert recording.rate == pytest.approx(30.0, rel=1e-4)
    assert recording.samples.shape == (1, 900)
    assert "x (mm) repeats the reading before it" in str(judge(recording))


def test_time_without_a_name_is_found_though_it_is_rounded_to_more_than_a_sample(tmp_path: Path) -> None:
    """A tracker writes three digits: hundredths up to ten seconds, tenths from there on; its names stand before tabs."""
    time = np.arange(600) / 30.0
    rows = "\n".join(f"{t:.2E}\t{20.0 * math.cos(3.0 * t):.3f}\t0.01\t0.01" for t in time)
    recording = load(tmp_path, f"x y dx dy\t\t\t\n{rows}", units={"displacement": "deg"})
    assert recording.rate == pytest.approx(30.0, rel=2e-3)
    assert "'x' is not named as a time, but its numbers rise evenly" in said(recording)
    assert np.abs(recording.samples[0][0]) == pytest.approx(math.radians(20.0), rel=1e-3)


def test_of_rows_turned_round_a_lost_stamp_is_where_it_was(tmp_path: Path) -> None:
    lines = table(HEADER, T[::-1], U[::-1]).splitlines()
    lines[61] = "," + lines[61].split(",", 1)[1]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    recipe = tmp_path / "recipe.toml"
    fields = '{column = 1, role = "time", unit = "s"}, {column = 2, role = "displacement", unit = "m"}'
    recipe.write_text(f"even = true\nfields = [{fields}]\n")
    (recording,) = read_runs(tmp_path / "a.csv", None, read_recipe(recipe))
    lost = len(T) - 61
    assert list(np.flatnonzero(~recording.valid)) == [lost]
    np.testing.assert_allclose(recording.samples[0][recording.valid], np.delete(U, lost), rtol=1e-8)


def test_the_rate_of_even_rows_is_no_better_known_than_a_hole_in_their_stamps_allows(tmp_path: Path) -> None:
    """A sonar on a busy computer: stamps stray by a third of an interval, and twelve rows are missing before the release."""
    jitter = np.random.default_rng(8).uniform(-4e-3, 4e-3, T.size)
    time = np.where(np.arange(T.size) < 40, T, T + 0.12) + jitter
    (tmp_path / "a.csv").write_text(table(HEADER, time, U))
    recipe = tmp_path / "recipe.toml"
    fields = '{column = 1, role = "time", unit = "s"}, {column = 2, role = "displacement", unit = "m"}'
    recipe.write_text(f"even = true\nfields = [{fields}]\n")
    (recording,) = read_runs(tmp_path / "a.csv", None, read_recipe(recipe))
    assert recording.rate_std is not None
    assert recording.rate == pytest.approx(100.0, abs=2.0 * recording.rate_std)
    assert recording.rate < 99.5
