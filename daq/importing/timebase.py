"""From time stamps to an even clock: its rate, how far the stamps stray, or why they make none; and the rows on it."""

import math
from dataclasses import dataclass

import numpy as np

from daq.importing.column_numbers import quantum
from daq.importing.errors import place, problem
from daq.importing.stamps import USE_RATE, NoClock, even_line, in_order, read_stamps
from daq.importing.table import SourceColumn, Table
from daq.importing.units import Unit
from daq.plain_text import counted
from daq.recording import Array, Gap, Index, Mask, runs

OFTEN_EQUAL = 0.25
"""Share of stamps equal to the one before, from which on no curve can be drawn through the readings at their stamps."""
EVEN = 1e-3
COMPUTED = 1e-6  # of a sampling interval: stamps that stray less were computed from a rate, and tell nothing of its error
TOO_IRREGULAR = 0.2
TOLD = 0.05  # of a sampling interval: digits beyond it tell nothing more
ROUGHER = 1.25  # times what local curves leave on an even clock: more at the stamps says that these show no reading's time
ROWS_OF_A_CURVE = 11
FEW_PARTS = 10  # of a record: stamps that stray on the average of one stray together
DEGREE = 7  # closer to a motion of seven readings a cycle than jitter of 5 % of an interval moves it
MOST_CURVES = 20_000
MOVES = 0.1  # of the largest variance within a curve's rows (but for one in twenty): at rest no stamp makes readings rougher
SHORTEST_PERIOD = 1e-100  # s; below it the squares of the steps are lost
MAX_GROWTH = 20
MAX_SAMPLES = 50_000_000


@dataclass(frozen=True, eq=False)
class Timebase:
    """An even clock for the rows of a table.

    `rows` (m,) are the rows to keep and `index` (m,) the sample each becomes, out of `count`. With `stamps` (m,), the times
    in s from sample 0 at which the rows were read, the samples are those of a curve through them.
    """

    rate: float
    rate_std: float | None
    rows: Index
    index: Index
    count: int
    stamps: Array | None = None
    notes: tuple[str, ...] = ()


def from_stamps(
    table: Table,
    column: SourceColumn,
    unit: Unit,
    values: Array,
    *,
    resample: bool,
    even: bool,
) -> Timebase:
    """Return the even clock that fits the stamps of `column`; `values` (channels, n) distinguish repeated rows from equal
    stamps. `even` rows were read at the mean rate of their stamps, however these stray.

    Raises ImportProblem when the stamps make no clock.
    """
    notes: list[str] = []
    time, rows = read_stamps(table, column, unit, notes)
    time, rows = in_order(table, column, time, rows, values, notes, even=even)
    steps = np.diff(time)
    period = float(np.median(steps))
    if period > 0.0:  # rounded as the stamps are, but not on the average
        period = float(np.mean(steps[np.abs(steps - period) < 0.5 * period]))
    else:
        period = float(time[-1] - time[0]) / len(steps)
    if not period > SHORTEST_PERIOD:
        raise problem(
            table.path, "the time stamps do not advance",
            USE_RATE,
            line=table.line(int(rows[0])), column=column.number,
        )  # fmt: skip
    rounding = _rounding(np.abs(column.values[rows]) * unit.scale)
    told = np.maximum(rounding, TOLD * period)
    weight = told**-2.0
    first = rows.max() if rows[0] > rows[-1] else rows.min()
    index = (
        np.sort(np.abs(rows - first))
        if even
        else _number_samples(table, column, time, rows, period, rounding, weight)
    )
    slope, start, _, _ = even_line(index, time, weight)
    within = bool(np.all(np.abs(time - start - slope * index) < 1.1 * told))
    slope, start, stray, rate_std = even_line(index, time)
    coarse = within and stray < np.max(rounding)
    uneven = stray > EVEN * slope
    spline = uneven and np.mean(np.diff(time) == 0.0) < OFTEN_EQUAL
    rougher = _rougher_at_stamps(values[:, rows], index, time / slope) if spline else math.inf
    rebuilt = even or (coarse and uneven and rougher > 1.0 / ROUGHER)
    held = _repeats(values[:, rows]) > OFTEN_EQUAL
    believed = rougher < ROUGHER and stray <= TOO_IRREGULAR * slope and not held
    resampled = spline and not rebuilt and (resample or believed)
    if stray > TOO_IRREGULAR * slope and not resampled and not rebuilt:
        worst = int(rows[np.argmax(np.abs(time - start - slope * index))])
        where = place(table.path, table.line(worst), column.number)
        raise _no_clock(where, slope, stray, equal=not spline, rougher=rougher > ROUGHER)
    notes.extend(_holes(table, index, time, rows))
    if rebuilt:
        # neighbouring stamps may stray together, as those of three digits do: the ends are known no better than one, and
        # no better than stamps stray on the average of many, as they do about a hole
        many = max(len(rows) // FEW_PARTS, 1)
        together = np.convolve(time - start - slope * index, np.full(many, 1.0 / many), "valid")
        off = max(stray, float(np.max(np.abs(together))))
        rate_std = max(rate_std, off / float(time[-1] - time[0]) / slope)
        rounded = f"no more than the rounding of the stamps, up to {1e3 * np.max(rounding):.3g} ms"
        why = "but the rows are said to be even" if even else rounded
        notes.append(
            f"{_strays(stray, slope)}, {why}: even times were rebuilt at {_rate(1.0 / slope, rate_std)}"
        )
    else:
        notes.append(_evenness(slope, stray, resampled))
    return Timebase(
        rate=float(f"{1.0 / slope:.13g}"),
        rate_std=rate_std if stray > COMPUTED * slope else None,
        rows=rows,
        index=index,
        count=int(index[-1]) + 1,
        stamps=time - start if resampled else None,
        notes=tuple(notes),
    )


def _holes(table: Table, index: Index, time: Array, rows: Index) -> tuple[str, ...]:
    """Return a sentence on the samples that are missing by their stamps, if any are."""
    lost = int(index[-1]) + 1 - len(index)
    if not lost:
        return ()
    first = int(np.flatnonzero(np.diff(index) > 1)[0])
    return (
        f"{counted(lost, 'sample is', 'samples are')} missing by the time stamps, "
        f"the first {time[first + 1] - time[0]:.6g} s after the first reading{table.at(rows[first + 1])}; marked as lost",
    )


def _evenness(slope: float, stray: float, resampled: bool) -> str:
    if stray <= EVEN * slope:
        return f"rate {1 / slope:.6g} Hz from the time stamps, which are even"
    done = (
        "the readings are smoother at even times than at their stamps, or repeat, so the mean rate is used "
        "(--resample uses the stamps)"
    )
    if resampled:
        done = "the samples were put on the even clock by a cubic spline through their stamps"
    return f"{_strays(stray, slope)}; {done}"


def _repeats(values: Array) -> float:
    """Return the share of rows that repeat the one before while a channel (channels, n) moves, of the channel with least."""
    values = values[:, np.isfinite(values).all(axis=0)]
    at = _few_rows(values.shape[1])
    if not len(at):
        return 0.0
    pieces = values[:, at]
    moves = np.ptp(pieces, axis=2) > MOVES * np.ptp(values, axis=1)[:, None]
    same = np.mean(np.diff(pieces, axis=2) == 0.0, axis=2)
    shares = [float(np.mean(one[there])) for one, there in zip(same, moves, strict=True) if there.any()]
    return min(shares, default=0.0)


def _few_rows(rows: int) -> Index:
    """Choose some stretches of a few rows each, (stretches, rows of a curve); none where there are too few."""
    last = rows - ROWS_OF_A_CURVE
    first = np.unique(np.linspace(0, last, max(min(last + 1, MOST_CURVES), 0)).astype(np.int64))
    return first[:, None] + np.arange(ROWS_OF_A_CURVE)


def _rougher_at_stamps(values: Array, index: Index, stamps: Array) -> float:
    """Return how much rougher readings (channels, n) are as functions of their `stamps` than on an even clock.

    Both clocks (n,) count in sampling intervals. It is the ratio of the squares that polynomials leave of every few rows
    in which a channel moves (geometric mean); 1 where there are too few rows.
    """
    there = np.isfinite(values).all(axis=0)
    values, index, stamps = values[:, there], index[there], stamps[there]
    at = _few_rows(len(stamps))
    if not len(at):
        return 1.0
    readings = values[:, at] - values[:, at].mean(axis=-1, keepdims=True)

    def left(clock: Array) -> Array:
        time = clock[at] - clock[at].mean(axis=-1, keepdims=True)
        basis, _ = np.linalg.qr((time / ROWS_OF_A_CURVE)[..., None] ** np.arange(DEGREE + 1))
        rest = readings - np.einsum("mij,mkj,cmk->cmi", basis, basis, readings)
        return np.asarray(np.sum(rest**2, axis=-1))

    even, stamped, whole = left(index.astype(float)), left(stamps), np.sum(readings**2, axis=-1)
    told = (even > 0.0) & (stamped > 0.0) & (whole > MOVES * np.quantile(whole, 0.95, axis=-1, keepdims=True))
    return float(np.exp(np.mean(np.log(stamped[told] / even[told])))) if told.any() else 1.0


def _rate(rate: float, std: float) -> str:
    """Return a rate in Hz with the digits that its error allows."""
    decimals = min(max(0, 1 - int(np.floor(np.log10(std)))), 9)
    return f"{rate:.{decimals}f} ± {std:.{decimals}f} Hz"


def _no_clock(where: str, slope: float, stray: float, *, equal: bool, rougher: bool) -> NoClock:
    """Return the refusal of stamps (s) that stray by this rms (s) from the nearest even clock, of interval `slope` (s).

    Many are `equal`, so that no curve goes through the readings; or these are `rougher` at their stamps than evenly read.
    """
    what, remedy, todo = _strays(stray, slope), {"even": True}, f"if the rows were read evenly, {USE_RATE}"
    if equal:
        what += ", and many are equal to the one before"
    elif rougher:
        what += ", and the readings are smoother if they were read evenly"
    else:
        remedy, todo = {"resample": True}, f"put the samples on an even clock with --resample; or {USE_RATE}"
    return NoClock(where, f"{what}; {todo}", remedy)


def _strays(stray: float, slope: float) -> str:
    """Say by how much stamps stray (rms, s) from an even clock of this interval (s)."""
    return (
        f"the time stamps stray by {1e3 * stray:.3g} ms rms from an even clock of {1.0 / slope:.6g} Hz "
        f"({100.0 * stray / slope:.3g} % of a sampling interval)"
    )


def _rounding(stamps: Array) -> Array:
    """Return what each stamp (n,), as it is written, may be off by its digits, s; significant ones round more by decades."""
    last = quantum(stamps)
    rounding = np.full(len(stamps), last)
    decade = np.floor(np.log10(np.maximum(stamps, 1e-300)))
    for edge in np.unique(decade[stamps > 0.0])[-2::-1]:
        early = decade <= edge
        if 0.0 < (finer := quantum(stamps[early])) < last:
            rounding[early] = 10.0 ** np.floor(np.log10(finer) + 1e-9)
    return rounding


def _number_samples(
    table: Table,
    column: SourceColumn,
    time: Array,
    rows: Index,
    period: float,
    rounding: Array,
    weight: Array,
) -> Index:
    """Return the sample that each stamp belongs to: consecutive, or with holes if holes make the clock more even.

    Holes are all long steps, or those that are longer than the rounding of their stamps allows.
    """
    plain: Index = np.arange(len(time), dtype=np.int64)
    steps = np.maximum(np.rint(np.diff(time) / period), 1.0)
    total = float(np.sum(steps)) + 1.0
    if total == len(time):
        return plain
    if total > MAX_GROWTH * len(time) + 1000 or total > MAX_SAMPLES:
        worst = int(np.argmax(steps))
        raise problem(
            table.path, f"the time stamp jumps from {time[worst]:.6g} s to {time[worst + 1]:.6g} s",
            f"split the file there; or {USE_RATE}",
            line=table.line(int(rows[worst + 1])), column=column.number,
        )  # fmt: skip
    rounded = np.abs(np.diff(time) - period) < 1.1 * rounding[1:]
    holed = [
        np.concatenate(([0], np.cumsum(one))).astype(np.int64)
        for one in (steps, np.where(rounded, 1.0, steps))
    ]
    strays = [even_line(one, time, weight)[2] for one in (*holed, plain)]
    best = int(np.argmin(strays[:-1]))
    return holed[best] if strays[best] < 0.5 * strays[-1] else plain


def on_clock(values: Array, clock: Timebase) -> tuple[Array, Mask]:
    """Return the samples on the even clock, shape (channels, count), and the mask of those that are there."""
    there = np.isfinite(values).all(axis=0)
    valid = np.zeros(clock.count, dtype=bool)
    samples = np.full((len(values), clock.count), np.nan)
    samples[:, clock.index] = values
    valid[clock.index] = there
    if clock.stamps is None or np.count_nonzero(there) < 4:
        return samples, valid
    return _resampled(values[:, there], clock.stamps[there], clock)


def _resampled(values: Array, stamps: Array, clock: Timebase) -> tuple[Array, Mask]:
    """Return a cubic spline through the stamped samples on the even clock; holes wider than 1.5 periods stay holes."""
    from scipy.interpolate import CubicSpline

    grid = np.arange(clock.count) / clock.rate
    stamps, first = np.unique(stamps, return_index=True)
    samples = np.asarray(CubicSpline(stamps, values[:, first], axis=1)(grid))
    after = np.clip(np.searchsorted(stamps, grid), 1, len(stamps) - 1)
    width = stamps[after] - stamps[after - 1]
    near = np.minimum(np.abs(grid - stamps[after]), np.abs(grid - stamps[after - 1]))
    period = 1.0 / clock.rate
    inside = (grid >= stamps[0] - 0.5 * period) & (grid <= stamps[-1] + 0.5 * period)
    valid = inside & ((width < 1.75 * period) | (near < 0.25 * period))
    valid &= np.isfinite(samples).all(axis=0)
    return np.where(valid, samples, np.nan), valid


def find_gaps(valid: Mask, clock: Timebase) -> tuple[Gap, ...]:
    """Return the runs of invalid samples: missing from the file, or there without a number."""
    present = np.zeros(clock.count, dtype=bool)
    present[clock.index] = True
    return tuple(
        Gap(a, b - a, "no reading there" if present[a:b].any() else "missing from the file")
        for a, b in runs(~valid)
    )
