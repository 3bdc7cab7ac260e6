"""A board that prints numbers, a line a sample, as a source; the index of a sample is by counter, stamp or order."""

import time
from collections.abc import Callable

import numpy as np

from daq.clock import fit_arrivals, fit_clock
from daq.errors import BoardError, LinkLost, PortError
from daq.port import Port
from daq.recording import Array
from daq.sources.line_format import LineFormat, Sample
from daq.sources.source import Reading, SourceDescription
from daq.sources.text_lines import LineCutter, header_of, parse_line

LISTEN_S = 3.0
LEAST_LINES = 24
LEAST_BURSTS = 10  # a line that delivers seldom is listened to for three times as long
MOST_LINES = 20_000
QUIET_S = 5.0
MOST_UNREAD = 200
COUNTER_BITS = 32
NUMBERED = 0.9
"""Share of lines from which on another stamp or number than the line's before is the rule, so that one line is known."""
WRAPS = (1 << 8, 1 << 16, 1 << 32)
MOST_LOST = 1_000_000
FOLLOWS = 0.05
NEAR_THE_END = 0.9


class CountedIndex:
    """Indices from a counter that wraps round after 8, 16 or 32 bits."""

    def __init__(self) -> None:
        self._last: int | None = None
        self.index = -1

    def next(self, counter: float) -> int:
        """Return the index of the next line. Raises LinkLost where the counter restarts in between."""
        now = round(counter)
        last = now - 1 if self._last is None else self._last
        step = now - last
        if step <= 0:
            wrap = next((w for w in WRAPS if NEAR_THE_END * w <= last < w and now < w), None)
            if wrap is None:
                raise LinkLost(
                    f"the counter went from {last} to {now}: the board restarted; what came before is kept"
                )
            step += wrap
        if step > MOST_LOST:
            raise BoardError(f"the counter jumps from {last} to {now}; is that column a counter?")
        self._last = now
        self.index += step
        return self.index


class StampedIndex:
    """Indices from time stamps (s) at a rate that is known nearly; it follows a slow drift between the two."""

    def __init__(self, rate: float, wrap_s: float) -> None:
        self._rate = rate
        self._wrap = wrap_s
        self._first: float | None = None
        self._last = 0.0
        self._phase = 0.0
        self.index = -1

    def next(self, stamp: float) -> tuple[int, float]:
        """Return the index of the next line and its time since the first, s. Raises LinkLost where time goes back."""
        if self._first is None:
            self._first = self._last = stamp
        if stamp < self._last:
            if self._last < NEAR_THE_END * self._wrap:
                raise LinkLost(
                    f"the time stamps go back from {self._last:g} s to {stamp:g} s: the board restarted; what came "
                    "before is kept"
                )
            self._first -= self._wrap
        self._last = stamp
        time = stamp - self._first
        ideal = time * self._rate - self._phase
        step = max(round(ideal) - self.index, 1)
        if step > MOST_LOST:
            raise BoardError(f"the time stamps jump to {stamp:g} s; is that column the time?")
        self.index += step
        self._phase += FOLLOWS * float(np.clip(ideal - self.index, -0.5, 0.5))
        return self.index, time


class LineSource:
    """Lines from a port. Without a `form` it is found by `decide`, from some seconds of lines that are listened to."""

    def __init__(
        self, port: Port, decide: Callable[[Sample], LineFormat], listen_s: float = LISTEN_S
    ) -> None:
        self._port = port
        self._cutter = LineCutter()
        self._unread = 0
        self.sample = self._listen(listen_s)
        self.form = decide(self.sample)
        numbers = self.sample.columns.get(self.form.clock.column or "", np.zeros(2))
        self._numbered = bool(np.mean(np.diff(numbers) != 0) > NUMBERED)
        self._rate, self._rate_std = self._found_rate()
        self.start()

    def describe(self) -> SourceDescription:
        """Return channels and rate, with a sentence on whose clock it is."""
        form, rate = self.form, self._rate
        channels = tuple(c.channel() for c in form.channels)
        whose = {
            "stamps": f"time from the board's stamps: {rate:.6g} Hz",
            "counter": f"samples counted by the board; {self._whose_rate()}",
            "arrival": f"no counter and no stamps: lines that are lost are not noticed, and {self._whose_rate()}",
        }
        return SourceDescription(f"lines from {self._port.name}", channels, rate, (whose[form.clock.kind],))

    def start(self) -> None:
        """Take the next line as the first sample."""
        self._counted = CountedIndex()
        wrap = self.form.clock.scale * 2.0**COUNTER_BITS
        self._stamped = StampedIndex(self._rate, wrap)
        self._lines = 0
        self._last: dict[str, float] = {}

    def read(self) -> list[Reading]:
        """Return the samples of the lines that have come, a reading for each run of indices without a hole."""
        data = self._port.read()
        rows: list[tuple[float, ...]] = []
        for text in self._cutter.feed(data):
            line = self._understood(text)
            if line is None or (self._numbered and line == self._last):
                continue  # the same line again, its number and all, is no other sample
            self._last = line
            rows.append((*self._placed(line), *(c.scale * line[c.column] for c in self.form.channels)))
        table = np.array(rows, dtype=np.float64).reshape(-1, 2 + len(self.form.channels))
        found = [Reading(0, table[:0, 2:], raw=data)]
        for part in np.split(table, np.flatnonzero(np.diff(table[:, 0]) != 1.0) + 1) if rows else ():
            stamps = 1e6 * part[:, 1] if self.form.clock.kind == "stamps" else None
            found.append(Reading(int(part[0, 0]), part[:, 2:], stamps))
        return found

    def close(self) -> None:
        """Give the port back."""
        self._port.close()

    def _placed(self, line: dict[str, float]) -> tuple[int, float]:
        clock = self.form.clock
        self._lines += 1
        number = self._lines if clock.column is None else line[clock.column]
        if clock.kind == "stamps":
            return self._stamped.next(clock.scale * number)
        index = self._counted.next(number)
        return index, index / self._rate

    def _understood(self, text: str) -> dict[str, float] | None:
        """Return the numbers of a line by column; None for one that lacks a column, of which only so many may come."""
        if not text:
            return None
        line = parse_line(text)
        clock = self.form.clock.column
        whole = line is not None and all(c in line for c in self.form.columns)
        if line is not None and whole and (clock is None or np.isfinite(line[clock])):
            return line
        self._unread += 1
        if self._unread > MOST_UNREAD:
            raise BoardError(
                f"{self._port.name}: {self._unread} lines do not have the form of the first, such as '{text[:40]}'; what "
                "came before is kept"
            )
        return None

    def _listen(self, seconds: float) -> Sample:
        """Return the lines of some seconds. Raises PortError where nothing comes, BoardError where it is no numbers."""
        began = time.monotonic()
        last = began
        lines: list[tuple[float, dict[str, float]]] = []
        header: tuple[str, ...] = ()
        odd = last_text = ""
        bursts = 0
        while (
            (now := time.monotonic()) - began < seconds
            or (bursts < LEAST_BURSTS and now - began < 3 * seconds)
            or (len(lines) < LEAST_LINES and now - last < QUIET_S)
        ):
            data = self._port.read()
            bursts += bool(data)
            last = now if data else last
            for text in self._cutter.feed(data):
                line = parse_line(text) if text else None
                if line is not None:
                    lines.append((now, line))
                    last_text = text
                elif text:
                    header, odd = header_of(text) or header, text
            if now - last > QUIET_S or len(lines) >= MOST_LINES or now - began > 3 * (seconds + QUIET_S):
                break
        if len(lines) < LEAST_LINES:
            raise self._nothing(len(lines), odd)
        names = list(lines[-1][1])
        kept = [(when, line) for when, line in lines if all(n in line for n in names)]
        columns = {name: np.array([line[name] for _, line in kept]) for name in names}
        arrivals = np.array([when for when, _ in kept])
        return Sample(columns=columns, arrivals=arrivals, header=header, text=last_text)

    def _nothing(self, count: int, odd: str) -> Exception:
        name = self._port.name
        if odd:
            plain = "".join(c for c in odd[:40] if c.isprintable() and c != "\ufffd")
            said = f", as '{plain}'" if len(plain) > 0.8 * len(odd[:40]) else ", nor text"
            return BoardError(
                f"{name}: the input has no lines of numbers{said}; check the baud rate (--baud), or what the "
                "board prints"
            )
        if count:
            return LinkLost(
                f"{name}: only {count} lines came; the board must print all the time, a line a sample"
            )
        return PortError(f"{name}: no line came in {QUIET_S:g} s; check cable, port and baud rate (--baud)")

    def _found_rate(self) -> tuple[float, float]:
        """Return the rate and its standard error, Hz: from stamps, as given, or by the arrival of lines."""
        form, clock, sample = self.form, self.form.clock, self.sample
        once = np.ones(len(sample.arrivals), dtype=np.bool_)
        number, arrivals = np.cumsum(once, dtype=np.float64), sample.arrivals
        if clock.column is not None:
            number = sample.columns[clock.column]
            once[1:] = (np.diff(number) != 0) | (not self._numbered)
            number, arrivals = number[once], arrivals[once]
        if clock.kind == "stamps":
            return _rate_of(clock.scale * number)
        if form.rate_hz is not None:
            return form.rate_hz, 0.0
        if clock.kind == "counter":
            counted = CountedIndex()
            number = np.array([counted.next(value) for value in number], dtype=np.float64)
        late = slice(len(number) // 8, None)  # what lay in a buffer came at once
        found = fit_arrivals(number[late].astype(int).tolist(), arrivals[late].tolist())
        if found is None or not np.isfinite(found.std):
            raise BoardError(f"{self._port.name}: the lines come too unevenly to tell a rate; give --rate")
        return found.rate, found.std

    def _whose_rate(self) -> str:
        if self.form.rate_hz is not None:
            return f"{self._rate:g} Hz as given"
        return (
            f"the rate is that at which lines arrive here, {self._rate:.5g} ± {self._rate_std:.2g} Hz "
            f"({100 * self._rate_std / self._rate:.2g} %); --rate gives a better one"
        )


def _rate_of(times: Array) -> tuple[float, float]:
    """Return the rate of evenly taken samples by least squares over their stamps, and its standard error, Hz."""
    step = np.diff(times)
    typical = float(np.median(step[step > 0])) if (step > 0).any() else 0.0
    if not typical > 0:
        raise BoardError("the time stamps do not rise; name another column, as --column time=1")
    # stamps in whole ms alternate between two steps
    ones = step[(step > 0.5 * typical) & (step < 1.5 * typical)]
    placed = StampedIndex(1.0 / float(np.mean(ones)), np.inf)
    found = fit_clock([placed.next(stamp)[0] for stamp in times], times.tolist())
    if found is None:
        raise BoardError("the time stamps are too few or rise too unevenly to tell a rate; give --rate")
    return found.rate, found.std
