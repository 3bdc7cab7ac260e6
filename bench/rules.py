"""Every rule earns its place: each constant of the judge halved and doubled, and what that does to the verdicts.

A constant that no verdict misses is a rule to delete.
"""

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: a process a core is enough

from bench.rigs import DATA, RIGS, sessions_of
from identify import priors
from identify.diagnosis.diagnose import Diagnosis, diagnose
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

TITLE = "Every rule earns its place"
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
    Record("adhesion", 0.01, 8110),
    Record(None, 0.0, 8111, paired=False),
    Record("quadratic_damping", 0.03, 8112, paired=False),
    Record("cubic_stiffness", 0.01, 8113, paired=False),
    Record("stribeck_friction", 0.03, 8114, paired=False),
    Record("hysteresis", 0.03, 8115, paired=False),
    Record("settling_stiffness", 0.03, 8116, paired=False),
)

REAL = (
    "pendulum in air", "pendulum in water", "pendulum from 1.6 rad", "pendulum, filmed", "coil shorted", "tower alone",
    "gauge with sphere", "beam", "ship", "disc",
)  # fmt: skip
"""Rigs whose releases are judged one by one, and together where these are two or three."""


@dataclass(frozen=True)
class Constant:
    """A number of identify/priors.py: its name and its value."""

    name: str
    value: float

    def times(self, factor: float) -> float:
        """Return it multiplied, as a whole number where it is one."""
        moved = self.value * factor
        return max(round(moved), 1) if isinstance(self.value, int) else moved


def constants() -> Iterator[Constant]:
    """Yield the numbers of the priors; the grids (SIZES, STRENGTHS, NOISE) and LEAKS are none."""
    for name, value in vars(priors).items():
        if name.isupper() and type(value) in (int, float):
            yield Constant(name, value)


@cache
def rigs() -> dict[str, tuple[str, ...]]:
    """Import the rigs; return the sessions of each diagnosis by its title. None where the recordings are not there."""
    folder, found = Path(tempfile.mkdtemp()), dict[str, tuple[str, ...]]()
    for rig in RIGS if DATA.is_dir() else ():
        if rig.title in REAL:
            names = sessions_of(rig, folder)
            found |= {f"{rig.title} {number}": (name,) for number, name in enumerate(names, 1)}
            if 1 < len(names) < 4:
                found[f"{rig.title} together"] = tuple(names)
    return found


def said(record: Record) -> str:
    """Return the verdict on a record, with what it names and what it cannot distinguish from that."""
    sample = draw(record.hidden, record.strength, record.seed)
    decay = FreeDecay(sample.rate, sample.displacement, sample.acceleration if record.paired else None)
    return _told(lambda: diagnose(prepare(decay, gain_uncertainty=GAIN_UNCERTAINTY)))


def said_of_rig(names: tuple[str, ...]) -> str:
    """Return the same of some sessions."""
    from station.operations.diagnosing import diagnose_sessions
    from station.operations.session_set import open_sessions
    from station.settings import Settings

    return _told(lambda: diagnose_sessions(open_sessions(names, Settings()))[0])


def _told(judge: Callable[[], Diagnosis]) -> str:
    try:
        found = judge()
    except Exception as error:  # what a constant breaks is an outcome
        return f"{type(error).__name__}: {error}"
    rivals = {name for s in found.suspects if s.effect.name in found.named for name in s.rivals}
    return " ".join((found.verdict, "+".join(sorted(found.named)), "/".join(sorted(rivals))))


def titles() -> list[str]:
    """Return what is judged, in a few words each."""
    return [*(record.title for record in RECORDS), *rigs()]


def with_constant(change: tuple[Constant, float] | None) -> list[str]:
    """Return what is said of all records with one constant multiplied by a factor, wherever it is used."""
    if change is not None:
        constant, factor = change
        for module in _users(constant):
            setattr(module, constant.name, constant.times(factor))
    return [*(said(record) for record in RECORDS), *(said_of_rig(names) for names in rigs().values())]


def _users(constant: Constant) -> Iterator[ModuleType]:
    """Yield the loaded modules that know a constant: the priors, and those that import it by name.

    Another constant of the same name has another value.
    """
    for module in tuple(sys.modules.values()):
        if module.__name__.startswith("identify.") and getattr(module, constant.name, None) == constant.value:
            yield module


def run(quick: bool) -> str:
    """Return the table as markdown: what half and twice each constant changes."""
    every = list(constants())[:: 6 if quick else 1]
    changes = [(c, factor) for c in every for factor in (0.5, 2.0)]
    judged = titles()
    with_constant(None)  # all modules that use a constant are loaded before one is moved
    with get_context("fork").Pool(WORKERS, maxtasksperchild=1) as pool:  # each change in a process of its own
        usual, *changed = pool.map(with_constant, [None, *changes], chunksize=1)
    rows, still = [], []
    for constant in every:
        cells = []
        for factor in (0.5, 2.0):
            other = changed[changes.index((constant, factor))]
            moved = zip(judged, usual, other, strict=True)
            cells.append("; ".join(f"{what}: {a} → {b}" for what, a, b in moved if a != b))
        if any(cells):
            half, twice = (cell or "none" for cell in cells)
            rows.append(f"| `{constant.name}` {constant.value:.3g} | {half} | {twice} |")
        else:
            still.append(f"`{constant.name}`")
    return (
        f"Each of the {len(every)} numbers of `identify/priors.py` halved and doubled, on {len(RECORDS)} simulated records and "
        f"{len(judged) - len(RECORDS)} diagnoses of real rigs. A verdict, a name or a rival that changes counts. Nothing changes "
        f"by {', '.join(still) or 'none'}.\n\n| constant | half changes | twice changes |\n|---|---|---|\n"
        + "\n".join(rows)
    )
