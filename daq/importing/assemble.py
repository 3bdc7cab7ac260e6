"""From a table to a recording: choose the columns, convert to SI, find the clock, mark what is missing."""

import numpy as np

from daq.importing.accelerometer import has_gravity
from daq.importing.channel_units import ORDER, in_si, is_angle, of_one_kind, unit_of, without_empty
from daq.importing.choose import Choice, choose_columns, left_out
from daq.importing.cutting import cut
from daq.importing.derived import find_derivation
from daq.importing.errors import ImportProblem, problem
from daq.importing.options import ImportOptions
from daq.importing.quantisation import rounding
from daq.importing.resampling import find_gaps, place
from daq.importing.table import Table
from daq.importing.timebase import EVEN, Timebase, from_rate, from_stamps, guess_time_unit
from daq.importing.units import SI_LINEAR, Unit
from daq.recording import Array, Channel, Mask, Recording

DERIVATIVES = (
    ("displacement", "velocity", 1),
    ("velocity", "acceleration", 1),
    ("displacement", "acceleration", 2),
)
MIN_SAMPLES = 8
FEWEST = 50
"""Samples of five cycles with ten readings each: of fewer nothing can be told, and tables of results are as short."""
MIN_RATE, MAX_RATE = 1e-3, 1e7


def assemble(table: Table, options: ImportOptions) -> Recording:
    """Return the recording that a table holds. Raises ImportProblem with file, line and column when it cannot be."""
    notes = list(table.notes)
    choices = choose_columns(table, options, notes)
    angular = is_angle(choices, options)
    units = {q: unit_of(table, choices[q], options, angular, notes) for q in ORDER if q in choices}
    choices = without_empty(table, choices, notes)
    choices = of_one_kind(table, choices, units, notes)
    quantities = [q for q in ORDER if q in choices]
    values = np.array([in_si(table, choices[q], units[q]) for q in quantities])
    clock = _clock(table, choices, options, values, notes)
    values = values[:, clock.rows]
    if not options.keep_derived:
        quantities, values = _without_derived(choices, units, quantities, values, clock, notes)
    if len(clock.rows) < MIN_SAMPLES:
        raise problem(
            table.path, f"has {len(clock.rows)} samples", f"a recording needs at least {MIN_SAMPLES}"
        )
    samples, valid = place(values, clock, resample=options.resample)
    if not valid.any():
        raise problem(
            table.path,
            "has no sample in which all channels hold a number",
            "leave a channel out, as in --column acceleration=none",
        )
    gaps = find_gaps(valid, clock)
    _say_invalid(table, choices, quantities, values, clock, notes)
    notes.extend(_strays(clock, samples[0], valid))
    if unused := left_out(table, choices):
        notes.append(unused)
    if not MIN_RATE <= clock.rate <= MAX_RATE:
        raise problem(
            table.path,
            f"its rate would be {clock.rate:.4g} Hz",
            "give the unit of the time with --unit time=..., or --rate in Hz",
        )
    if not options.keep_offset:
        samples = _without_gravity(choices, units, quantities, samples, notes)
    if samples.shape[1] < FEWEST:
        notes.append(
            f"{samples.shape[1]} samples only: the amplitudes or periods of swings are no recording; what is needed is the "
            "motion itself, five cycles or more with at least ten readings each"
        )
    channels = tuple(Channel(choices[q].column.label or q, q, units[q].si) for q in quantities)
    made = Recording(
        clock.rate, channels, samples, valid, gaps, clock.rate_std, None, tuple(notes), table.run
    )
    return _between(table, made, clock, options)


def _without_gravity(
    choices: dict[str, Choice],
    units: dict[str, Unit],
    quantities: list[str],
    samples: Array,
    notes: list[str],
) -> Array:
    """Take out of an acceleration the offset that gravity makes in it: the median of the record."""
    made = samples.copy()
    for row, quantity in enumerate(quantities):
        if quantity != "acceleration" or units[quantity].si != "m/s^2":
            continue
        if choices[quantity].column.gravity or has_gravity(samples[row]):
            offset = float(np.nanmedian(samples[row]))
            made[row] -= offset
            notes.append(
                f"{choices[quantity].column.place} has gravity in it: its median, {offset:.4g} m/s^2, "
                "was taken out as an offset (--keep-offset keeps it)"
            )
    return made


def _between(table: Table, recording: Recording, clock: Timebase, options: ImportOptions) -> Recording:
    """Return the part of a recording between the times that the operator gave, in the time of the file."""
    if options.start is None and options.stop is None:
        return recording
    count = recording.samples.shape[1]
    first, last = clock.origin, clock.origin + (count - 1) / clock.rate
    start = 0 if options.start is None else max(0, round((options.start - first) * clock.rate))
    stop = count if options.stop is None else min(count, round((options.stop - first) * clock.rate) + 1)
    if stop - start < MIN_SAMPLES or not recording.valid[start:stop].any():
        raise problem(
            table.path, "holds nothing between these times", f"its own go from {first:.6g} s to {last:.6g} s"
        )
    return cut(recording, start, stop)


def _clock(
    table: Table, choices: dict[str, Choice], options: ImportOptions, values: Array, notes: list[str]
) -> Timebase:
    """Return the clock: the rate asked for, else the stamps, else the rate that the file names."""
    rows = values.shape[1]
    time = choices.get("time")
    if options.rate is not None:
        if time is not None and time.asked:
            raise problem(table.path, "a time column and a rate were both given", "give one of them")
        unused = f"; {time.column.place} was not used" if time is not None else ""
        return from_rate(options.rate, rows, f"rate {options.rate:g} Hz, as asked{unused}")
    if time is None:
        rates = {c.column.rate for q, c in choices.items() if c.column.rate is not None}
        if len(rates) > 1:
            said = ", ".join(f"{rate:g} Hz" for rate in sorted(rates))
            raise problem(
                table.path,
                f"the channels have different rates ({said})",
                "leave one out with --column ...=none",
            )
        rate, source = (rates.pop(), "the file") if rates else (table.rate, table.rate_source)
        if rate is None:
            raise problem(
                table.path,
                "has no time column and names no rate",
                "name the time with --column time=... or give --rate in Hz",
                options=("--rate HZ",),
            )
        return from_rate(rate, rows, f"rate {rate:.6g} Hz, from {source}")
    in_si(table, time, SI_LINEAR["time"])
    column = time.column
    if "time" in options.units or time.unit is not None:
        unit = unit_of(table, time, options, False, notes)
    else:
        unit, why = guess_time_unit(column)
        how = (
            "; dates or times of day"
            if column.clock
            else f"; it names no unit: {why} (change it with --unit time=...)"
        )
        notes.append(f"{column.place} read as time{how}")
    try:
        return from_stamps(table, column, unit, values, resample=options.resample)
    except ImportProblem:
        if options.start is None and options.stop is None:
            raise
    between = (
        -np.inf if options.start is None else options.start,
        np.inf if options.stop is None else options.stop,
    )
    return from_stamps(table, column, unit, values, resample=options.resample, between=between)


def _without_derived(
    choices: dict[str, Choice],
    units: dict[str, Unit],
    quantities: list[str],
    values: Array,
    clock: Timebase,
    notes: list[str],
) -> tuple[list[str], Array]:
    """Leave out the velocity or acceleration that the logger computed from another channel of the file."""
    uneven = clock.stamps is not None and clock.stray_rms * clock.rate > EVEN
    stamps = clock.stamps if uneven and not clock.coarse else None
    steps = {q: rounding(choices[q].column.values)[clock.rows] * units[q].scale for q in quantities}
    drop: set[str] = set()
    for source, target, order in DERIVATIVES:
        if source not in quantities or target not in quantities or target in drop:
            continue
        said = f"{choices[target].column.place} was left out: "
        found = find_derivation(
            values[quantities.index(source)],
            values[quantities.index(target)],
            clock.rate,
            order,
            stamps,
            (steps[source], steps[target]),
        )
        origin = choices[source].column.place
        if found:
            drop.add(target)
            notes.append(
                f"{said}its numbers are a finite difference of {origin} to within their rounding "
                f"({100 * found.residual / found.rms:.2g} % of its rms), not a sensor of its own (--keep-derived keeps it)"
            )
        elif choices[target].named_derived and not choices[target].asked:
            drop.add(target)
            notes.append(
                f"{said}its name says that it is derived, and {origin} is there (--keep-derived keeps it)"
            )
    keep = [i for i, q in enumerate(quantities) if q not in drop]
    return [quantities[i] for i in keep], values[keep]


def _say_invalid(
    table: Table,
    choices: dict[str, Choice],
    quantities: list[str],
    values: Array,
    clock: Timebase,
    notes: list[str],
) -> None:
    for quantity, channel in zip(quantities, values, strict=True):
        holes = np.flatnonzero(~np.isfinite(channel))
        if len(holes):
            line = table.line(int(clock.rows[holes[0]]))
            where = f", the first in line {line}" if line else ""
            notes.append(
                f"{len(holes)} of {len(channel)} samples of the {quantity} are empty or not finite{where}; "
                "they count as invalid"
            )
    blank = max((int(np.count_nonzero(~np.isfinite(c))) for c in values), default=0)
    if blank > len(clock.rows) // 2:
        names = ", ".join(choices[q].column.place for q in quantities)
        notes.append(
            f"more than half of the samples are invalid: check whether {names} were sampled together"
        )


def _strays(clock: Timebase, samples: Array, valid: Mask) -> tuple[str, ...]:
    """Return the clock's sentences, with the stray as a share of the motion's period where one can be seen."""
    if clock.stray_rms * clock.rate <= EVEN or clock.coarse or not clock.notes or samples.shape[-1] < FEWEST:
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
