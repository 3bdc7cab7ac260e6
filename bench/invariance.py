"""The same record told otherwise: what may not change a verdict does not change a printed digit of it.

Each record is written to a CSV file as it is and in changed copies (jitter in the last bits, all signs turned, other
units, another clock origin, another order of channels and releases), imported and judged. The record as it is is judged
again with another number of threads, under other kernels of linear algebra, and by machine code for another processor.
"""

import argparse
import io
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import redirect_stderr
from dataclasses import dataclass, field, replace
from pathlib import Path

if __name__ != "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

TITLE = "The same record in another form"
ROOT = Path(__file__).resolve().parents[1]
DATA = Path(os.environ.get("STATION_DATA", ROOT / ".." / "shared" / "data"))
JITTER = 1e-12
CLOCK_ORIGIN_S = 1000.0
HIDDEN = 27


@dataclass(frozen=True)
class Record:
    """One release, or several that are judged together: files, and how they are imported."""

    title: str
    files: tuple[str, ...]
    options: dict[str, object] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Where the files are: examples come with the project."""
        return ROOT if self.files[0].startswith(("examples/", "tests/")) else DATA


SILVERBOX = {
    "columns": {"force": "V1", "displacement": "V2"},
    "units": {"force": "V", "displacement": "V"},
    "rate": 610.35,
}
ROLL = {"columns": {"displacement": "phi"}}
EXAMPLES = (
    Record("example, nothing hidden", ("examples/simulated_plain.csv",)),
    Record("example, Stribeck", ("examples/simulated_stribeck.csv",)),
    Record("example, drift", ("examples/simulated_drift.csv",)),
    Record("example, ship", ("examples/ship_roll.csv",)),
    Record("example, disc", ("examples/spring_disc.csv",)),
    Record("example, silverbox", ("examples/silverbox.mat",), SILVERBOX),
)
RIGS = (
    Record("pendulum in water", ("labelled/pendulum_in_water.csv",)),
    Record("pendulum, encoder", ("rigs/pendulum_encoder_1.txt", "rigs/pendulum_encoder_2.txt")),
    Record("pendulum, filmed", ("rigs/pendulum_filmed.txt",)),
    Record("coil shorted", ("labelled/magnet_coil_shorted.csv",)),
    Record("tower, pendulum free", ("labelled/tower_pendulum_free.txt",)),
    Record("gauge with sphere", ("labelled/water_gauge_with_damper.txt",)),
    Record("wheel driven", ("labelled/wheel_driven_200mA.csv",)),
    Record("beam", ("rigs/beam_hammer_1.txt",)),
    Record("torsion", ("rigs/torsion_ten_runs.csv",)),
    Record("second wheel", ("rigs/wheel2_100mA.txt", "rigs/wheel2_200mA.txt")),
    Record("ship", ("ship_roll/model_test_21337.csv", "ship_roll/model_test_21338.csv"), ROLL),
    Record("disc", ("spring_disc/release_1.csv", "spring_disc/release_2.csv")),
)
QUICK = (EXAMPLES[1], EXAMPLES[2], Record("hidden 14", ("tests/data/hidden/release_14.csv",)))


@dataclass(frozen=True)
class Column:
    """One column of a file: a quantity, its unit, and its numbers; a lost reading is an empty cell."""

    quantity: str
    unit: str
    numbers: tuple[float | None, ...]

    def times(self, factor: float, unit: str | None = None) -> "Column":
        """Return the column in another unit."""
        scaled = tuple(None if number is None else number * factor for number in self.numbers)
        return Column(self.quantity, self.unit if unit is None else unit, scaled)


Table = tuple[Column, ...]
Change = Callable[[Table], Table]

G = 9.80665
DEGREES = 57.29577951308232
OTHER_UNITS = {
    "m": (1e3, "mm"),
    "m/s": (1e3, "mm/s"),
    "m/s^2": (1.0 / G, "g"),
    "rad": (DEGREES, "deg"),
    "rad/s": (DEGREES, "deg/s"),
    "rad/s^2": (DEGREES, "deg/s^2"),
    "V": (1e3, "mV"),
}


def jittered(table: Table) -> Table:
    """Return the readings times 1 + 1e-12 n, n of the normal distribution."""
    import numpy as np

    random = np.random.default_rng(12)
    return tuple(
        column
        if column.quantity == "time"
        else replace(
            column,
            numbers=tuple(
                None if x is None else x * (1.0 + JITTER * n)
                for x, n in zip(
                    column.numbers, random.standard_normal(len(column.numbers)).tolist(), strict=True
                )
            ),
        )
        for column in table
    )


def turned(table: Table) -> Table:
    """Return the record with the sign of all channels turned."""
    return tuple(column if column.quantity == "time" else column.times(-1.0) for column in table)


def in_other_units(table: Table) -> Table:
    """Return the record in mm, degrees, g and mV."""
    return tuple(
        column.times(*OTHER_UNITS[column.unit]) if column.unit in OTHER_UNITS else column for column in table
    )


def begun_later(table: Table) -> Table:
    """Return the record with the clock starting at another time."""
    return tuple(
        replace(column, numbers=tuple(t + CLOCK_ORIGIN_S for t in column.numbers if t is not None))
        if column.quantity == "time"
        else column
        for column in table
    )


def in_another_order(table: Table) -> Table:
    """Return the channels in another order."""
    return tuple(reversed(table))


CHANGES: dict[str, Change] = {
    "jitter of 1e-12": jittered,
    "signs turned": turned,
    "other units": in_other_units,
    "clock from 1000 s": begun_later,
    "other order": in_another_order,
}


def environments() -> dict[str, dict[str, str]]:
    """Return the environments in which the record as it is is judged again: threads, kernels, machine code."""
    flags = _processor_flags()
    kernels = ["Prescott"]
    kernels += ["Haswell"] if "avx2" in flags else []
    kernels += ["SkylakeX"] if "avx512f" in flags else []
    found = {"eight threads, not one": {"OPENBLAS_NUM_THREADS": "8"}}
    if platform.machine() in ("x86_64", "AMD64"):
        found |= {f"kernel {kernel}": {"OPENBLAS_CORETYPE": kernel} for kernel in kernels}
    return found | {"machine code, generic": {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}}


def _processor_flags() -> set[str]:
    facts = Path("/proc/cpuinfo")
    text = facts.read_text(encoding="utf-8", errors="replace") if facts.is_file() else ""
    flags = re.search(r"^flags\s*:(.*)$", text, re.MULTILINE)
    return set(flags.group(1).split()) if flags else set()


def records(quick: bool) -> tuple[Record, ...]:
    """Return the records to judge: a few that come with the project, or all that are here."""
    if quick:
        return QUICK
    hidden = tuple(Record(f"hidden {i}", (f"hidden/release_{i:02d}.csv",)) for i in range(HIDDEN))
    there = [r for r in (*hidden, *RIGS) if all((DATA / file).is_file() for file in r.files)]
    return (*EXAMPLES, *there)


def tables_of(record: Record) -> list[Table]:
    """Return the releases of a record, imported as published."""
    from bench.recipes import recipe_of
    from daq.importing.options import ImportOptions
    from daq.session_info import SessionInfo
    from station.results.sessions import import_file

    tables = []
    with tempfile.TemporaryDirectory() as made:
        for file in record.files:
            path = record.folder / file
            options, recipe = ImportOptions(**record.options), recipe_of(file)
            imported = import_file(path, None, Path(made), options, SessionInfo(), recipe, anew=True)
            tables += [_table(recording) for recording in imported.recordings]
    return tables


def _table(recording) -> Table:
    time = tuple(i / recording.rate for i in range(len(recording.valid)))
    columns = [Column("time", "s", time)]
    for channel, samples in zip(recording.channels, recording.samples, strict=True):
        numbers = [x if good else None for x, good in zip(samples.tolist(), recording.valid, strict=True)]
        columns.append(Column(channel.quantity, channel.unit, tuple(numbers)))
    return tuple(columns)


def written(table: Table, file: Path) -> None:
    """Write a table as a CSV file with the unit of each column in its header, every digit kept."""
    rows = zip(*(column.numbers for column in table), strict=True)
    lines = [",".join(f"{column.quantity} [{column.unit}]" for column in table)]
    lines += [",".join("" if x is None else repr(x) for x in row) for row in rows]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


@dataclass(frozen=True)
class Said:
    """What was printed of a record: its verdict, its names, its suspects in order with their nats, and every line."""

    verdict: str
    named: tuple[str, ...]
    suspects: tuple[str, ...]
    evidence: tuple[float, ...]
    lines: tuple[str, ...]

    def differs(self, other: "Said", *, turned: bool = False, reordered: bool = False) -> tuple[str, str]:
        """Return in what two verdicts differ, as ("verdict" | "suspects" | "digits" | "", where)."""
        if (self.verdict, self.named) != (other.verdict, other.named):
            return "verdict", f"{self.verdict} {self.named} | {other.verdict} {other.named}"
        if self.suspects != other.suspects:
            return "suspects", f"{self.suspects} | {other.suspects}"
        mine, others = (said._compared(turned, reordered) for said in (self, other))
        for one, two in zip(mine, others, strict=False):
            if one != two:
                return "digits", f"{one} | {two}"
        return ("digits", "more lines") if len(mine) != len(others) else ("", "")

    def moved(self, other: "Said") -> float:
        """Return the largest change of the evidence of a suspect that both print, as a share of it or of one nat."""
        others = dict(zip(other.suspects, other.evidence, strict=True))
        both = zip(self.suspects, self.evidence, strict=True)
        return max((abs(e - others[s]) / max(abs(e), 1.0) for s, e in both if s in others), default=0.0)

    def _compared(self, turned: bool, reordered: bool) -> list[str]:
        lines = [line.strip() for line in self.lines if line.strip()]
        if reordered:
            lines = [line for line in lines if "release_" not in line]
        return [unsigned(line) for line in lines] if turned else lines


def unsigned(line: str) -> str:
    """Return a line without signs and sides: of a motion turned over they are the other ones, and phases half a turn off, and left out."""
    sides = re.sub(r"\b(?:positive|negative)\b", "either", line)
    plain = re.sub(r"(?<![\w)])[-+−](?=[\d.])", "", sides)
    return re.sub(r"phase (?:= )?[\d.]+", "phase", plain)


def all_at_once(table: Table) -> Table:
    """Return a table changed in every way but its sign."""
    for change in (jittered, in_other_units, begun_later, in_another_order):
        table = change(table)
    return table


def judged(tables: list[Table], *, reordered: bool = False) -> Said:
    """Import tables and diagnose them, together where they are several."""
    from rich.console import Console

    from identify.errors import NotIdentifiable
    from station.operations.diagnosing import diagnose_sessions
    from station.operations.session_set import open_sessions
    from station.settings import Settings
    from station.story.engineering_values import UNKNOWN
    from station.text.diagnosis_text import shown_suspects, told
    from station.text.layout import show

    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        files = []
        for number, table in enumerate(tables, start=1):
            file = folder / f"release_{number}.csv"
            written(table, file)
            files.append(str(file))
        if reordered:
            files.reverse()
        settings = Settings().model_copy(update={"sessions": folder / "sessions"})
        try:
            with redirect_stderr(io.StringIO()):  # what the importer understood
                _, document = diagnose_sessions(open_sessions(tuple(files), settings))
        except NotIdentifiable as refusal:
            return Said("refused", (), (), (), (str(refusal),))
        text = io.StringIO()
        show(Console(file=text, width=2000, no_color=True), told(document, UNKNOWN))
    shown = shown_suspects(document)
    return Said(
        document.verdict,
        tuple(document.named),
        tuple(suspect.effect for suspect in shown),
        tuple(float(suspect.evidence or 0.0) for suspect in shown),
        tuple(text.getvalue().splitlines()),
    )


def differences(said: dict[str, dict[str, Said]]) -> Iterator[tuple[str, str, str, str]]:
    """Yield (record, change, kind, where) for every change that altered what was said of a record."""
    for title, told in said.items():
        base = told["as it is"]
        for change, other in told.items():
            kind, where = base.differs(
                other, turned=change == "signs turned", reordered=change == "other order"
            )
            if kind:
                yield title, change, kind, where


def all_said(quick: bool, only: str = "") -> dict[str, dict[str, Said]]:
    """Judge every record as it is, in changed copies, and in other environments; return what was said by record and change."""
    said: dict[str, dict[str, Said]] = {}
    with ThreadPoolExecutor(1) as beside:
        elsewhere = {
            name: beside.submit(lambda e=environment: list(said_elsewhere(quick, only, e)))
            for name, environment in environments().items()
        }
        for title, change, told in _in_this_process(quick, only, changed=True):
            said.setdefault(title, {})[change] = told
        for name, judging in elsewhere.items():
            for title, told in judging.result():
                said[title][name] = told
    return said


def _in_this_process(quick: bool, only: str, *, changed: bool) -> Iterator[tuple[str, str, Said]]:
    for record in records(quick):
        if only and only not in record.title:
            continue
        tables = tables_of(record)
        yield record.title, "as it is", judged(tables)
        for name, change in CHANGES.items() if changed else ():
            told = [change(table) for table in tables]
            yield record.title, name, judged(told, reordered=change is in_another_order)


def said_elsewhere(quick: bool, only: str, environment: dict[str, str]) -> Iterator[tuple[str, Said]]:
    command = [sys.executable, "-m", "bench.invariance", "--only", only, *(["--quick"] if quick else [])]
    result = subprocess.run(
        command,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    if result.returncode:
        raise RuntimeError(f"judging with {environment} failed: {result.stderr[-2000:]}")
    for line in result.stdout.splitlines():
        told = json.loads(line)
        title = told.pop("title")
        yield title, Said(**{name: tuple(v) if isinstance(v, list) else v for name, v in told.items()})


def run(quick: bool) -> str:
    """Return the table as markdown."""
    said = all_said(quick)
    found = list(differences(said))
    for row in found:
        print(*row, sep="\n    ", file=sys.stderr)
    changes = list(next(iter(said.values())))[1:]
    moved = ", ".join(
        f"{change} {100.0 * max(told['as it is'].moved(told[change]) for told in said.values()):.1g}"
        for change in changes
    )
    rest = "".join(f"\n- {title}, {change}: {kind}: {where[:200]}" for title, change, kind, where in found)
    return (
        f"Other names, another order or other digits in what `station diagnose` prints of {len(said)} records (hidden releases, "
        f"examples, rigs): in {len(found)}. The evidence moves by at most (% of it or of one nat): "
        f"{moved}.{rest}"
    )


def main() -> None:
    """Print what is said of each record in this process's environment, a line of JSON each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="")
    chosen = parser.parse_args()
    for title, _, told in _in_this_process(chosen.quick, chosen.only, changed=False):
        print(json.dumps({"title": title, **told.__dict__}), flush=True)


if __name__ == "__main__":
    main()
