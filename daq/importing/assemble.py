"""From a table to a recording: choose the columns, convert to SI, find the clock, mark what is missing."""


import numpy as np
from scipy.interpolate import CubicSpline

from daq.importing.choose import Choice, choose_columns, left_out
from daq.importing.derived import find_derivation
from daq.importing.errors import problem
from daq.importing.options import NONE, ImportOptions
from daq.importing.table import Table
from daq.importing.timebase import EVEN, Timebase, from_rate, from_stamps, guess_time_unit
from daq.importing.units import SI_ANGULAR, SI_LINEAR, Unit, parse_scaled_unit
from daq.recording import Array, Channel, Gap, Mask, Recording

ORDER = ("displacement", "velocity", "acceleration", "force")
DERIVATIVES = (("displacement", "velocity", 1), ("velocity", "acceleration", 1), ("displacement", "acceleration", 2))
MIN_SAMPLES = 8
LARGEST = 1e150


def assemble(table: Table, options: ImportOptions) -> Recording:
    """Return the recording that a table holds. Raises ImportProblem with file, line and column when it cannot be."""
    notes = list(table.notes)
    choices = choose_columns(table, options, notes)
    angular = any(choices[q].angular for q in ORDER if q in choices)
    units = {q: _unit(table, choices[q], options, angular, notes) for q in ORDER if q in choices}
    choices = _without_empty(table, choices, notes)
    quantities = [q for q in ORDER if q in choices]
    _same_kind(table, {q: units[q] for q in quantities})
    values = np.array([_converted(table, choices[q], units[q]) for q in quantities])
    clock = _clock(table, choices, options, values, notes)
    values = values[:, clock.rows]
    if not options.keep_derived:
        quantities, values = _without_derived(choices, quantities, values, clock, notes)
    if len(clock.rows) < MIN_SAMPLES:
        raise problem(table.path, f"has {len(clock.rows)} samples", f"a recording needs at least {MIN_SAMPLES}")
    samples, valid = _placed(values, clock, options)
    if not valid.any():
        raise problem(table.path, "has no sample in which all channels hold a number", "leave a channel out (columns ...=none)")
    gaps = _gaps(valid, clock)
    _say_invalid(table, choices, quantities, values, clock, notes)
    notes.extend(_strays(clock, samples[0], valid))
    if unused := left_out(table, choices):
        notes.append(unused)
    channels = tuple(
        Channel(choices[q].column.label or q, q, units[q].si, sensor="") for q in quantities
    )
    return Recording(clock.rate, channels, samples, valid, gaps, clock.rate_std, None, tuple(notes))


def _unit(table: Table, choice: Choice, options: ImportOptions, angular: bool, notes: list[str]) -> Unit:
    """Return the unit of a channel: from the options, the header, or SI by default; tell which."""
    quantity, text = choice.quantity, options.units.get(choice.quantity)
    if text is not None:
        unit = parse_scaled_unit(text)
        if unit is None or unit.quantity not in (None, quantity):
            raise problem(table.path, f"'{text}' is no unit of {quantity} that is known here", _unit_examples(quantity))
        notes.append(f"{choice.column.place} read as {quantity} in {text}, as asked")
        return unit
    asked = ", chosen by the options" if choice.asked else ""
    if choice.unit is not None:
        notes.append(f"{choice.column.place} read as {quantity} in {choice.unit_text}{asked}")
        return choice.unit
    unit = (SI_ANGULAR if angular else SI_LINEAR)[quantity]
    notes.append(
        f"{choice.column.place} read as {quantity}{asked}; it names no unit: {unit.si} was assumed (change it with units {quantity}=...)"
    )
    return unit


def _unit_examples(quantity: str) -> str:
    examples = {
        "time": "s, ms, us", "displacement": "m, mm, um, in, rad, deg, V or a scale such as '0.0025 m'",
        "velocity": "m/s, mm/s, rad/s, deg/s, V", "acceleration": "m/s^2, g, rad/s^2, V", "force": "N, kN, N m, V",
    }  # fmt: skip
    return f"give one of {examples[quantity]}"


def _without_empty(table: Table, choices: dict[str, Choice], notes: list[str]) -> dict[str, Choice]:
    kept = {}
    for quantity, choice in choices.items():
        if choice.column.bad is None and not np.isfinite(choice.column.values).any():
            if quantity == "time" or choice.asked:
                raise problem(table.path, f"{choice.column.place} holds no numbers", "name another column", column=choice.column.number)
            notes.append(f"{choice.column.place} holds no numbers and was left out")
            continue
        kept[quantity] = choice
    if not any(q in kept for q in ORDER[:3]):
        raise problem(table.path, "no channel holds numbers", "name another column or another file")
    return kept


def _same_kind(table: Table, units: dict[str, Unit]) -> None:
    """Refuse an angle beside a length: no single motion has both."""
    mechanical = {q: u for q, u in units.items() if u.quantity is not None}
    if len({u.angular for u in mechanical.values()}) > 1:
        said = ", ".join(f"{q} in {u.si}" for q, u in mechanical.items())
        leave = list(mechanical)[-1]
        raise problem(
            table.path, f"mixes an angle with a length ({said})",
            f"leave one out (columns {leave}={NONE}), or give a scale that makes them alike, such as units {leave}='4.0 rad/s^2'",
        )  # fmt: skip


def _converted(table: Table, choice: Choice, unit: Unit) -> Array:
    column = choice.column
    if column.bad is not None:
        line, text = column.bad
        raise problem(
            table.path, f"'{text}' in {column.place} is not a number",
            "repair or remove the line, or choose another column", line=line, column=column.number,
        )  # fmt: skip
    with np.errstate(over="ignore", invalid="ignore"):
        values = column.values * unit.scale
    finite = np.isfinite(column.values)
    if np.any(np.abs(values[finite]) > LARGEST):
        row = int(np.flatnonzero(finite & ~(np.abs(values) <= LARGEST))[0])
        raise problem(
            table.path, f"{column.values[row]:.3g} is too large to be a measured {choice.quantity}",
            "repair or remove the line", line=table.line(row), column=column.number,
        )  # fmt: skip
    return np.where(np.isfinite(values), values, np.nan)


def _clock(
    table: Table, choices: dict[str, Choice], options: ImportOptions, values: Array, notes: list[str]
) -> Timebase:
    rows = values.shape[1]
    time = choices.get("time")
    if time is None:
        rates = {c.column.rate for q, c in choices.items() if c.column.rate is not None}
        if options.rate is not None:
            return from_rate(options.rate, rows, f"rate {options.rate:g} Hz, as asked")
        if len(rates) == 1:
            rate = rates.pop()
            return from_rate(rate, rows, f"rate {rate:.6g} Hz, from the file")
        if table.rate is not None:
            return from_rate(table.rate, rows, f"rate {table.rate:.6g} Hz, from {table.rate_source}")
        raise problem(
            table.path, "has no time column and no rate", "name the time column (columns time=...) or give the rate in Hz"
        )
    column = _checked(table, time)
    if "time" in options.units or time.unit is not None:
        unit = _unit(table, time, options, False, notes)
    else:
        unit, why = guess_time_unit(column)
        notes.append(
            f"{column.place} read as time"
            + (", dates or times of day" if column.clock else f"; it names no unit: {why} (change it with units time=...)")
        )
    return from_stamps(table, column, unit, values, resample=options.resample)


def _checked(table: Table, time: Choice):  # type: ignore[no-untyped-def]
    _converted(table, time, SI_LINEAR["time"])
    return time.column


def _without_derived(
    choices: dict[str, Choice], quantities: list[str], values: Array, clock: Timebase, notes: list[str]
) -> tuple[list[str], Array]:
    """Leave out the velocity or acceleration that the logger computed from another channel of the file."""
    uneven = clock.stamps is not None and clock.stray_rms * clock.rate > EVEN
    stamps = clock.stamps if uneven else None
    drop: set[str] = set()
    for source, target, order in DERIVATIVES:
        if source not in quantities or target not in quantities or target in drop:
            continue
        said = f"{choices[target].column.place} was left out: "
        found = find_derivation(
            values[quantities.index(source)], values[quantities.index(target)], clock.rate, order, stamps
        )
        origin = choices[source].column.place
        if found:
            drop.add(target)
            notes.append(
                f"{said}its numbers are a finite difference of {origin} to within their rounding "
                f"({100 * found.residual / found.rms:.2g} % of its rms), not a sensor of its own (keep_derived keeps it)"
            )
        elif choices[target].named_derived and not choices[target].asked:
            drop.add(target)
            notes.append(f"{said}its name says that it is derived, and {origin} is there (keep_derived keeps it)")
    keep = [i for i, q in enumerate(quantities) if q not in drop]
    return [quantities[i] for i in keep], values[keep]


def _placed(values: Array, clock: Timebase, options: ImportOptions) -> tuple[Array, Mask]:
    """Return the samples on the even clock, shape (channels, count), and the mask of those that are there."""
    there = np.isfinite(values).all(axis=0)
    valid = np.zeros(clock.count, dtype=bool)
    samples = np.full((len(values), clock.count), np.nan)
    samples[:, clock.index] = values
    valid[clock.index] = there
    if not options.resample or clock.stamps is None or np.count_nonzero(there) < 4:
        return samples, valid
    return _resampled(values[:, there], clock.stamps[there], clock)


def _resampled(values: Array, stamps: Array, clock: Timebase) -> tuple[Array, Mask]:
    """Return a cubic spline through the stamped samples on the even clock; holes wider than 1.5 periods stay holes."""
    grid = np.arange(clock.count) / clock.rate
    stamps, first = np.unique(stamps, return_index=True)
    samples = np.asarray(CubicSpline(stamps, values[:, first], axis=1)(grid))
    after = np.clip(np.searchsorted(stamps, grid), 1, len(stamps) - 1)
    width = stamps[after] - stamps[after - 1]
    near = np.minimum(np.abs(grid - stamps[after]), np.abs(grid - stamps[after - 1]))
    period = 1.0 / clock.rate
    inside = (grid >= stamps[0] - 0.5 * period) & (grid <= stamps[-1] + 0.5 * period)
    valid = inside & ((width < 1.75 * period) | (near < 0.25 * period))
    return np.where(valid, samples, np.nan), valid


def _gaps(valid: Mask, clock: Timebase) -> tuple[Gap, ...]:
    """Return the runs of invalid samples: missing from the file, or there without a number."""
    present = np.zeros(clock.count, dtype=bool)
    present[clock.index] = True
    edges = np.flatnonzero(np.diff(np.concatenate(([False], ~valid, [False])).astype(np.int8)))
    return tuple(
        Gap(int(a), int(b - a), "no number in the file" if present[a:b].any() else "missing from the file")
        for a, b in zip(edges[::2], edges[1::2], strict=True)
    )


def _say_invalid(
    table: Table, choices: dict[str, Choice], quantities: list[str], values: Array, clock: Timebase, notes: list[str]
) -> None:
    for quantity, channel in zip(quantities, values, strict=True):
        holes = np.flatnonzero(~np.isfinite(channel))
        if len(holes):
            line = table.line(int(clock.rows[holes[0]]))
            where = f", the first in line {line}" if line else ""
            notes.append(
                f"{len(holes)} of {len(channel)} samples of the {quantity} are empty or not finite{where}; they count as invalid"
            )
    blank = max((int(np.count_nonzero(~np.isfinite(c))) for c in values), default=0)
    if blank > len(clock.rows) // 2:
        names = ", ".join(choices[q].column.place for q in quantities)
        notes.append(f"more than half of the samples are invalid: check whether {names} were sampled together")


def _strays(clock: Timebase, samples: Array, valid: Mask) -> tuple[str, ...]:
    """Return the clock's sentences, with the stray as a share of the motion's period where one can be seen."""
    if clock.stray_rms * clock.rate <= EVEN or not clock.notes:
        return clock.notes
    filled = np.where(valid, samples, np.nan)
    filled = np.nan_to_num(filled - np.nanmean(filled))
    power = np.abs(np.fft.rfft(filled * np.hanning(len(filled)))) ** 2
    peak = int(np.argmax(power[2:])) + 2 if len(power) > 4 else 0
    if not peak or power[peak] < 20.0 * float(np.median(power[2:])):
        return clock.notes
    period = len(filled) / clock.rate / peak
    share = f"the motion's period is about {period:.3g} s: the stray is {100 * clock.stray_rms / period:.2g} % of it"
    return (*clock.notes, share)


