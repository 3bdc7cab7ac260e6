"""Every rule earns its place: each constant of the judge halved and doubled, and what that does to the verdicts.

A constant that no verdict misses is a rule to delete. Numbers that bound a search or a step belong to the numerics: a
verdict that hangs on one of these is a fault.
"""

import ast
import importlib
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: a process a core is enough

import identify
from identify.diagnosis.diagnose import diagnose
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

TITLE = "Every rule earns its place"
ROOMS = ("evidence", "diagnosis", "curves", "fitting")
WORKERS = int(os.environ.get("BENCH_WORKERS", "2"))
GAIN_UNCERTAINTY = 2e-4


@dataclass(frozen=True)
class Record:
    """What is hidden, how strongly, with which seed, and whether there are two channels or displacement alone."""

    hidden: str | None
    strength: float
    seed: int
    paired: bool = True

    @property
    def title(self) -> str:
        """What it is, in a few words."""
        what = f"{self.hidden} {100 * self.strength:g} %" if self.hidden else "nothing"
        return what if self.paired else f"{what}, one channel"


RECORDS = (
    Record(None, 0.0, 8101),
    Record("quadratic_damping", 0.0003, 8102),
    Record("bilinear_stiffness", 0.0003, 8103),
    Record("end_stop", 0.001, 8104),
    Record("hysteresis", 0.01, 8105),
    Record("second_mass", 0.003, 8106),
    Record("mains_hum", 0.003, 8107),
    Record("ac_coupling", 0.01, 8108),
    Record("freeplay+cubic_damping", 0.02, 8109),
    Record("fading_friction", 0.01, 8110),
    Record(None, 0.0, 8111, paired=False),
    Record("quadratic_damping", 0.03, 8112, paired=False),
    Record("cubic_stiffness", 0.01, 8113, paired=False),
    Record("stribeck_friction", 0.03, 8114, paired=False),
)


@dataclass(frozen=True)
class Constant:
    """A number at the top of a module: where, its name and its value."""

    module: str
    name: str
    value: float

    def times(self, factor: float) -> float:
        """Return it multiplied, as a whole number where it is one."""
        moved = self.value * factor
        return max(round(moved), 1) if isinstance(self.value, int) else moved


def constants() -> Iterator[Constant]:
    """Yield the numbers that stand alone at the top of the judge's modules."""
    for room in ROOMS:
        for path in sorted((Path(identify.__file__).parent / room).glob("*.py")):
            module = f"identify.{room}.{path.stem}"
            for statement in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                    value = getattr(importlib.import_module(module), statement.targets[0].id)
                    if type(value) in (int, float):
                        yield Constant(module, statement.targets[0].id, value)


def said(record: Record) -> str:
    """Return the verdict on a record, with what it names and what it cannot distinguish from that."""
    sample = draw(record.hidden, record.strength, record.seed)
    decay = FreeDecay(sample.rate, sample.displacement, sample.acceleration if record.paired else None)
    try:
        found = diagnose(prepare(decay, gain_uncertainty=GAIN_UNCERTAINTY))
    except Exception as error:  # what a constant breaks is an outcome
        return f"{type(error).__name__}: {error}"
    rivals = {name for s in found.suspects if s.effect.name in found.named for name in s.rivals}
    return " ".join((found.verdict, "+".join(sorted(found.named)), "/".join(sorted(rivals))))


def with_constant(change: tuple[Constant, float] | None) -> list[str]:
    """Return what is said of all records with one constant multiplied by a factor, wherever it is used."""
    if change is not None:
        constant, factor = change
        for module in _users(constant):
            setattr(module, constant.name, constant.times(factor))
    return [said(record) for record in RECORDS]


def _users(constant: Constant) -> Iterator[ModuleType]:
    """Yield the modules that know a constant: its own, and those that import it by name."""
    own = sys.modules[constant.module]
    yield own
    for module in tuple(sys.modules.values()):
        path = getattr(module, "__file__", None)
        if module is not own and path and module.__name__.startswith("identify."):
            tree = ast.parse(Path(path).read_text(encoding="utf-8"))
            for node in ast.walk(tree):
                names = {alias.name for alias in node.names} if isinstance(node, ast.ImportFrom) else set()
                if constant.name in names and getattr(node, "module", "") == constant.module:
                    yield module


def run(quick: bool) -> str:
    """Return the table as markdown: the constants that turn a verdict, and how many turn none."""
    every = list(constants())
    every = every[::20] if quick else every
    changes = [(c, factor) for c in every for factor in (0.5, 2.0)]
    with get_context("fork").Pool(WORKERS, maxtasksperchild=1) as pool:  # each change in a process of its own
        usual, *changed = pool.map(with_constant, [None, *changes], chunksize=1)
    rows = []
    for constant in every:
        cells = []
        for factor in (0.5, 2.0):
            other = changed[changes.index((constant, factor))]
            cells.append([r.title for r, a, b in zip(RECORDS, usual, other, strict=True) if a != b])
        if any(cells):
            half, twice = ("; ".join(cell) or "none" for cell in cells)
            where = constant.module.removeprefix("identify.")
            rows.append(f"| `{where}.{constant.name}` {constant.value:g} | {half} | {twice} |")
    return (
        f"Each of {len(every)} constants of {', '.join(f'`{room}`' for room in ROOMS)} halved and doubled, on "
        f"{len(RECORDS)} simulated records ({', '.join(r.title for r in RECORDS)}). A verdict, a name or a rival that "
        f"changes counts. {len(every) - len(rows)} constants change nothing; the others:\n\n"
        "| constant | half changes | twice changes |\n|---|---|---|\n" + "\n".join(rows)
    )
