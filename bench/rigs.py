"""Real rigs with a known effect: what is named on each, singly and over several releases, and what that predicts."""

import os
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from identify.diagnosis.diagnose import Diagnosis

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: one thread is the fastest here

TITLE = "Real rigs with a known effect"
DATA = Path(os.environ.get("STATION_DATA", Path(__file__).resolve().parents[1] / ".." / "shared" / "data"))
ROLL = {"columns": {"displacement": "phi"}}
HARDENING = {"cubic_stiffness", "quintic_stiffness", "signed_quadratic_stiffness"}
GROWING = {"quadratic_damping", "cubic_damping", "position_dependent_damping"}


OUTCOMES = {
    "found": "all that is known to be there, and nothing else",
    "missed": "not all that is known to be there",
    "silent": "nothing is known to be there, nothing is named",
    "tolerated": "what is named may be there",
    "wrong": "a name that is not there",
}


@dataclass(frozen=True)
class Rig:
    """Recordings of one rig: files, what is there (any one of each set must be named), and what else may be named.

    What is there is what its authors say. What else may be named was widened with results in view (joints of a tower and
    bearings of a wheel have presliding and hysteresis), and so it is counted apart. Dahl's friction on the second wheel was
    added when it was named there: its constants agree between the currents, and it predicts each current from each
    other one better than the usual model does. On the disc it was added when two releases together named it beside drag:
    what one release shows predicts the frequency of the other, an error of 19 % of the motion against 1 %.
    """

    title: str
    files: tuple[str, ...]
    there: tuple[set[str], ...] = ()
    also: frozenset[str] = frozenset()
    options: tuple[tuple[str, object], ...] = ()


SOFTENING = frozenset(
    {"cubic_stiffness", "pendulum_stiffness", "hysteresis", "signed_quadratic_stiffness", "dahl_friction"}
)
RIGS = (
    Rig("pendulum in air", ("labelled/pendulum_in_air.csv",), (), frozenset({"pendulum_stiffness", "quadratic_damping"})),
    Rig("pendulum in water", ("labelled/pendulum_in_water.csv",), (GROWING,), frozenset({"pendulum_stiffness"})),
    Rig("pendulum from 1.6 rad", ("labelled/pendulum_large_angle.csv",), ({"pendulum_stiffness"},), frozenset({"quadratic_damping"})),
    Rig("pendulum, encoder", tuple(f"rigs/pendulum_encoder_{i}.txt" for i in (1, 2, 3)), ({"pendulum_stiffness"},)),
    Rig("pendulum, filmed", ("rigs/pendulum_filmed.txt",), (GROWING, {"pendulum_stiffness", "cubic_stiffness"})),
    Rig("coil shorted", ("labelled/magnet_coil_shorted.csv",)),
    Rig("coil open", ("labelled/magnet_coil_10kohm.csv",)),
    Rig("tower alone", ("labelled/tower_alone.txt",), (), SOFTENING),
    Rig("tower, pendulum locked", ("labelled/tower_pendulum_locked.txt",), (), SOFTENING),
    Rig("tower, pendulum free", ("labelled/tower_pendulum_free.txt",), ({"second_mass"},), SOFTENING),
    Rig("gauge without sphere", ("labelled/water_gauge_without_damper.txt",)),
    Rig("gauge with sphere", ("labelled/water_gauge_with_damper.txt",), (GROWING,)),
    Rig("wheel driven", ("labelled/wheel_driven_200mA.csv",), ({"harmonic_forcing", "driven"},)),
    Rig("beam", tuple(f"rigs/beam_hammer_{i}.txt" for i in (1, 2, 3)), (HARDENING,), frozenset(GROWING)),
    Rig("beam with magnets", tuple(f"rigs/beam_magnet_hammer_{i}.txt" for i in (1, 2)), (), frozenset(HARDENING | GROWING)),
    Rig("torsion", ("rigs/torsion_ten_runs.csv",)),
    Rig("torsion with magnets", ("rigs/torsion_magnet_free.csv",)),
    Rig("second wheel", tuple(f"rigs/wheel2_{i:03d}mA.txt" for i in (0, 100, 200, 400)), (), frozenset({"cubic_stiffness", "hysteresis", "dahl_friction", "signed_quadratic_stiffness"})),
    Rig("second wheel, 10 g", ("rigs/wheel2_10g.txt",), (), frozenset({"quadratic_stiffness", "bilinear_stiffness", "cubic_stiffness", "pendulum_stiffness"})),
    Rig("wheel", tuple(f"pohl_wheel/brake_{i:03d}mA.csv" for i in (0, 100, 200, 400)), (), frozenset({"cubic_stiffness", "hysteresis", "signed_quadratic_stiffness"})),
    Rig("ship", tuple(f"ship_roll/model_test_{i}.csv" for i in (21337, 21338)), (GROWING, HARDENING), options=(("columns", {"displacement": "phi"}),)),
    Rig("ship at 15 knots", ("rigs/ship_15_knots.csv",), options=(("columns", {"displacement": "phi"}),)),
    Rig("disc", tuple(f"spring_disc/release_{i}.csv" for i in (1, 2)), (GROWING,), frozenset({"hysteresis", "dahl_friction"})),
    Rig("disc, small", ("spring_disc/release_4_small.csv",)),
)  # fmt: skip


def outcome(rig: Rig, named: set[str]) -> str:
    """Return what a diagnosis did, one of OUTCOMES."""
    if not named <= set(rig.also).union(*rig.there):
        return "wrong"
    if rig.there:
        return "found" if all(named & group for group in rig.there) else "missed"
    return "tolerated" if named else "silent"


def sessions_of(rig: Rig, folder: Path) -> list[str]:
    """Import the files of a rig as published and return the folders of their sessions."""
    from bench.recipes import recipe_of
    from daq.importing.options import ImportOptions
    from daq.session_info import SessionInfo
    from station.results.sessions import import_file

    found = []
    for name in rig.files:
        stem = name.replace("/", "_").replace(".", "_")
        imported = import_file(
            DATA / name,
            folder / stem,
            folder,
            ImportOptions(**dict(rig.options)),
            SessionInfo(),
            recipe_of(name),
        )
        found += [str(session.folder) for session in imported.sessions]
    return found


@dataclass(frozen=True)
class Said:
    """What was said of some releases; `found` is None where they were refused."""

    verdict: str
    named: set[str]
    predicted: str
    left: str
    seconds: float
    found: "Diagnosis | None" = None


@dataclass(frozen=True)
class Pair:
    """What is predicted of one release from another, error in % of the motion, by the usual model and by the named one."""

    rig: str
    usual: float
    named: float


def _said(names: list[str]) -> Said:
    from identify.errors import NotIdentifiable
    from station.operations.diagnosing import diagnose_sessions
    from station.operations.session_set import open_sessions
    from station.settings import Settings

    began = time.perf_counter()
    try:
        found, _ = diagnose_sessions(open_sessions(tuple(names), Settings()))
    except NotIdentifiable as refusal:
        return Said("refused", set(), "", str(refusal)[:80], time.perf_counter() - began)
    told = found.confirmation
    predicted = ""
    if told is not None:
        predicted = f"{told.usual.typical('motion'):.3g} → {told.found.typical('motion'):.3g}"
        predicted += f" ({told.better}/{told.parts})" if told.effects else ""
    left = f"{found.baseline.fit.reduced:.3g} → {found.final.reduced:.3g}"
    return Said(found.verdict, set(found.named), predicted, left, time.perf_counter() - began, found)


def pairs_of(rig: str, alone: Sequence[Said]) -> list[Pair]:
    """Return what each release of a rig, where something is named on it alone, predicts of each other one."""
    from identify.fitting.validation import validate

    pairs = []
    for one in alone:
        if one.found is None or not one.named:
            continue
        others = [o.found for o in alone if o is not one and o.found is not None]
        for other in others:
            values = one.found.final.parameters
            told = validate(one.found.final.model, values, other.decays, fitted_to=one.found.decays)
            pairs.append(Pair(rig, told.usual_motion_percent, told.motion_percent))
    return pairs


def _of_pairs(pairs: list[Pair]) -> str:
    """Return the pairs of releases in words, rig by rig."""
    told = []
    for rig in dict.fromkeys(pair.rig for pair in pairs):
        own = [pair for pair in pairs if pair.rig == rig]
        usual, named = (statistics.median(getattr(pair, kind) for pair in own) for kind in ("usual", "named"))
        told.append(f"{rig} {_better(own)} of {len(own)} ({usual:.3g} → {named:.3g})")
    return (
        f"Other releases of a rig, predicted from one on which something is named: the named model is better on {_better(pairs)} of "
        f"{len(pairs)} pairs (median error, % of the motion): {'; '.join(told)}."
    )


def _better(pairs: list[Pair]) -> int:
    return sum(pair.named < pair.usual for pair in pairs)


def run(quick: bool) -> str:
    """Return the table as markdown. Raises FileNotFoundError where the recordings are not there."""
    if not DATA.is_dir():
        raise FileNotFoundError(
            "the recordings are not here (../shared/data, or the folder named by STATION_DATA)"
        )
    only = os.environ.get("RIGS", "")
    rows, silent, counts = list[str](), list[str](), Counter[str]()
    pairs: list[Pair] = []
    with tempfile.TemporaryDirectory() as made:
        for rig in RIGS:
            if only and not any(word in rig.title for word in only.split(",")):
                continue
            names = sessions_of(rig, Path(made))
            sets = [names] if quick or len(names) == 1 else [names, *([name] for name in names)]
            every, ended = [], []
            for place, chosen in enumerate(sets):
                said = _said(chosen)
                result = (
                    "missed"
                    if said.verdict == "refused"
                    else outcome(rig, said.named | ({"driven"} & {said.verdict}))
                )
                every.append(said)
                ended.append(result)
                which = "all" if len(chosen) > 1 else f"{place or 1}"
                print(
                    f"| {rig.title} | {which} of {len(names)} | {said.verdict} | {' + '.join(sorted(said.named))} "
                    f"| {result} | {said.predicted} | {said.left} | {said.seconds:.1f} |",
                    flush=True,
                )
            together = len(sets[0]) > 1
            if set(ended) == {"silent"}:
                silent.append(f"{rig.title} ({len(ended)})")
            else:
                rows.append(_row(rig, every, ended, together))
            counts.update(ended)
            pairs += pairs_of(rig.title, every[together:])
    return (
        "| rig | together | each alone | named | prediction error, % of the motion |\n|---|---|---|---|---|\n"
        + "\n".join(rows)
        + "\n\nErrors: usual model → named model, of all releases together. Silent in every diagnosis: "
        + f"{'; '.join(silent) or 'none'}. Of {counts.total()} diagnoses: "
        + "; ".join(f"{counts[kind]} {kind} ({meaning})" for kind, meaning in OUTCOMES.items())
        + "."
        + (f"\n\n{_of_pairs(pairs)}" if pairs else "")
    )


def _row(rig: Rig, every: list[Said], ended: list[str], together: bool) -> str:
    """Return what was said of a rig as a row; with `together` the first diagnosis is that of all its releases."""
    alone = ", ".join(f"{n} {kind}" for kind, n in Counter(ended[together:]).items())
    named = Counter(" + ".join(sorted(said.named)) for said in every if said.named)
    names = ", ".join(f"{name} x{n}" for name, n in named.items())
    return f"| {rig.title} | {ended[0] if together else ''} | {alone} | {names} | {every[0].predicted} |"
