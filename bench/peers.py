"""What the peers name on the same records: PySINDy's optimisers, and polynomial surfaces with significance factors.

Each peer is tried at several settings of its own. Which it plays with, and how much evidence it must have, is tuned on
other records than those that are scored: the least evidence that claims an effect in 2 % of releases with nothing
hidden, and the setting that then names and claims
most.
"""

import os
import warnings
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: a process a core is enough

import numpy as np

from bench.bounds import SEEN, expected_drops
from bench.detection import draw, visible
from bench.diagnosis import BASE, EFFECTS, STRENGTHS, Case, judge_all, setting_of
from identify.effects.library import LIBRARY
from identify.errors import NotIdentifiable
from identify.fitting.initial_values import scales_of, term_starts
from identify.model.measured_path import force_along
from identify.model.model import Term
from identify.preprocessing.equation_error import moving
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import DOUBT

TITLE = "Peers on the same records"
NO_COLUMN = ("hysteresis", "maxwell_element", "second_mass", "harmonic_forcing")
CURVE = (3e-5, 1e-4, *STRENGTHS)
"""Strengths of the records that are scored, down to where nobody can see anything."""

_PROBE = 0.002
SCORED, TUNED, NOTHING_SCORED, NOTHING_TUNED = 1000, 8000, 5000, 9000
"""First seeds of the records."""

STLSQ_SETTINGS = tuple((t, a) for t in (0.02, 0.05, 0.1, 0.2, 0.3, 0.5) for a in (1e-6, 1e-3, 1e-1))
"""Threshold, as a part of what the known terms leave, and ridge weight."""

SURFACE_ORDERS = (0, 3, 5)
"""Highest order of the surface; 0 stands for linear with the six polynomials of the library alone."""

KEEP_PERCENT = (0.0, 1e-4, 1e-3, 1e-2, 1e-1)
"""Significance factor, % of the variance, below which a term of the surface is dropped and the rest fitted again."""

_POLYNOMIALS = {
    (2, 0): "quadratic_stiffness",
    (3, 0): "cubic_stiffness",
    (5, 0): "quintic_stiffness",
    (0, 2): "quadratic_damping",
    (0, 3): "cubic_damping",
    (2, 1): "position_dependent_damping",
}


@dataclass(frozen=True)
class Pick:
    """What a peer names first, and its evidence for it: a drop of BIC, or a significance factor in %."""

    name: str
    evidence: float


Picks = dict[str, dict[tuple[float, ...], Pick]]
"""By peer and by setting of the peer."""


def columns_of(setting: PreparedDecay) -> tuple[list[str], np.ndarray]:
    """Return the columns that a library of functions of u, v, t can have, and the effect that each stands for."""
    motion = setting.motion
    scales = scales_of(setting, {})
    names, columns = [], []
    for effect in LIBRARY:
        if (
            effect.kind != "physics"
            or effect.name in NO_COLUMN
            or not effect.has_meaning_for(setting.window.unit)
        ):
            continue
        for variant in effect.variants:
            term = Term(effect, variant)
            for inner in term_starts(term, scales) if effect.name not in BASE else ({},):
                along = (setting.time, motion.displacement, motion.velocity, setting.frequency)
                columns.append(force_along(term, inner, *along))
                names.append(effect.name)
    return names, np.column_stack([*columns, np.ones(len(columns[0]))])


def _pinned(setting: PreparedDecay) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return names, candidate columns of length 1 and target, masked, with the known terms projected out."""
    names, table = columns_of(setting)
    used = moving(setting.motion)
    target, table = -setting.motion.acceleration[used], table[used]
    known = [i for i, n in enumerate(names) if n in BASE] + [table.shape[1] - 1]
    basis = np.linalg.qr(table[:, known] / np.linalg.norm(table[:, known], axis=0))[0]
    rest = [i for i, n in enumerate(names) if n not in BASE]
    size = np.linalg.norm(table[:, rest], axis=0)
    left = table[:, rest] - basis @ (basis.T @ table[:, rest])
    norm = np.linalg.norm(left, axis=0)
    told = norm > 1e-6 * size  # the others are sums of the known terms on this motion
    return (
        [names[i] for i, t in zip(rest, told, strict=True) if t],
        left[:, told] / norm[told],
        target - basis @ (basis.T @ target),
    )


def _sindy(setting: PreparedDecay) -> Picks:
    import pysindy

    names, columns, target = _pinned(setting)

    def first(optimizer: pysindy.optimizers.BaseOptimizer) -> Pick:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a threshold removes every term is an answer here
            weights = np.abs(optimizer.fit(columns, target[:, None]).coef_[0])
        if not np.any(weights > 0.0):
            return Pick("none", -np.inf)
        best = int(np.argmax(weights))
        total = float(target @ target)
        left = max(total - float(columns[:, best] @ target) ** 2, 1e-300)
        return Pick(names[best], len(target) * np.log(total / left) - np.log(len(target)))

    size = float(np.linalg.norm(target))
    return {
        "PySINDy FROLS": {(): first(pysindy.FROLS(max_iter=1, alpha=1e-12))},
        "PySINDy STLSQ": {
            (t, a): first(pysindy.STLSQ(threshold=t * size, alpha=a)) for t, a in STLSQ_SETTINGS
        },
    }


def _surface(setting: PreparedDecay) -> Picks:
    """Fit a polynomial of u and v with sgn v; name the effect of the extra term with the largest significance (eq. 19)."""
    motion = setting.motion
    used = moving(motion)
    u, v = motion.displacement[used], motion.velocity[used]
    target = -motion.acceleration[used]
    picks = {}
    for order in SURFACE_ORDERS:
        powers = [(i, j) for i in range(order + 1) for j in range(order + 1) if 2 <= i + j <= order]
        powers = powers or list(_POLYNOMIALS)
        # An even power of v pumps over one half of the cycle; drag is v|v|, and so it stands in the paper.
        extra = np.column_stack([u**i * (v * np.abs(v) if j == 2 else v**j) for i, j in powers])
        table = np.column_stack([u, v, np.sign(v), np.ones_like(u), extra])
        for least in KEEP_PERCENT:
            kept = list(range(table.shape[1]))
            while True:
                factors = _factors(table[:, kept], target)
                factors[: kept.index(4) if 4 in kept else min(4, len(kept))] = np.inf
                weakest = int(np.argmin(factors))
                if len(kept) == 4 or factors[weakest] >= least:
                    break
                del kept[weakest]
            extras = {powers[k - 4]: f for k, f in zip(kept, factors, strict=True) if k >= 4}
            best = max(extras, key=lambda p: extras[p], default=None)
            picks[(order, least)] = (
                Pick("none", -np.inf)
                if best is None
                else Pick(_POLYNOMIALS.get(best, f"u^{best[0]} v^{best[1]}"), extras[best])
            )
    return {"polynomial surface, significance factors": picks}


def _factors(table: np.ndarray, target: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(table, axis=0)
    weights = np.linalg.lstsq(table / size, target, rcond=None)[0] / size
    return np.asarray(100.0 * np.var(table * weights, axis=0) / np.var(target))


def picks_of(case: Case) -> Picks:
    """Return what every peer names first in a record, at each of its settings; {} when the record is refused."""
    try:
        setting = setting_of(case)[0]
    except (NotIdentifiable, ValueError):
        return {}
    return _sindy(setting) | _surface(setting)


def tune(
    peer: str, hidden: list[tuple[Case, Picks]], nothing: list[Picks]
) -> tuple[tuple[float, ...], float]:
    """Return the setting of a peer that names and claims most, and the evidence that 2 % of releases with nothing hidden reach."""
    least = {
        s: float(np.quantile([p[peer][s].evidence for p in nothing], 1.0 - DOUBT, method="higher"))
        for s in nothing[0][peer]
    }
    right = {
        s: sum(_named(case, picks, peer, s, at) for case, picks in hidden for at in (-np.inf, least[s]))
        for s in least
    }
    best = max(right, key=lambda s: right[s])
    return best, least[best]


def _named(case: Case, picks: Picks, peer: str, setting: tuple[float, ...], least: float = -np.inf) -> bool:
    return bool(picks) and picks[peer][setting].name == case.hidden and picks[peer][setting].evidence > least


def run(quick: bool) -> str:
    """Return the table as markdown."""
    seeds, tuned, nothing = (1, 1, 30) if quick else (3, 3, 150)

    def hidden(first: int, count: int, strengths: Iterable[float]) -> list[Case]:
        return [Case(e, s, first + i) for e in EFFECTS for s in strengths for i in range(count)]

    scored = hidden(SCORED, seeds, CURVE)
    tuning = hidden(TUNED, tuned, STRENGTHS)
    quiet = [Case(None, 0.0, NOTHING_SCORED + i) for i in range(40)]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        on_scored, on_tuning, on_quiet, on_nothing = (
            list(pool.map(picks_of, cases, chunksize=8))
            for cases in (scored, tuning, quiet, [Case(None, 0.0, NOTHING_TUNED + i) for i in range(nothing)])
        )
    lines = [
        "| named first, % | "
        + " | ".join(f"{100 * s:g} %" for s in CURVE)
        + f" | 0.3-3 % | claimed with nothing hidden, of {len(quiet)} |",
        "|---|" + "---|" * (len(CURVE) + 2),
    ]
    played, curves = [], {}
    for peer in on_scored[0]:
        setting, least = tune(
            peer, list(zip(tuning, on_tuning, strict=True)), [picks for picks in on_nothing if picks]
        )
        first, claimed = (
            [_named(c, p, peer, setting, at) for c, p in zip(scored, on_scored, strict=True)]
            for at in (-np.inf, least)
        )
        alarms = sum(bool(p) and p[peer][setting].evidence > least for p in on_quiet)
        lines.append(_row(peer, scored, first, claimed, alarms))
        curves[peer] = _curve(scored, first)
        played.append(_words(peer, setting, least))
    ours = judge_all([*scored, *quiet])
    first = [o.first == o.case.hidden for o in ours[: len(scored)]]
    claims = [o.verdict not in ("nothing_missing", "not_enough_data") for o in ours]
    claimed = [f and c for f, c in zip(first, claims, strict=False)]
    curves["the station"] = _curve(scored, first)
    faint = np.geomspace(CURVE[0], CURVE[-1], 200)
    seen = visible(expected_drops(_PROBE, seeds).ravel(), _PROBE, faint, SEEN)
    draw(CURVE, curves, (faint, seen))
    lines.append(_row("**the station**", scored, first, claimed, sum(claims[len(scored) :])))
    return (
        f"{len(EFFECTS) * seeds} records a strength: {len(EFFECTS)} effects, {seeds} seeds. In brackets: also claimed.\n\n"
        "![Detection against strength](pictures/detection.png)\n\n"
        + "\n".join(lines)
        + "\n\nThe peers get the station's aligned motion. PySINDy gets a column for each of the "
        f"{len(EFFECTS) - len(NO_COLUMN)} effects that can be one (not memory, second mass, forcing); the surface can name six effects. "
        f"Tuned on {len(tuning)} other records with an effect and {nothing} without: the evidence for a claim is what {100 * DOUBT:g} % of those "
        f"without exceed. {'; '.join(played)}."
    )


def _curve(cases: list[Case], told: list[bool]) -> list[float]:
    return [
        100.0 * float(np.mean([t for c, t in zip(cases, told, strict=True) if c.strength == s]))
        for s in CURVE
    ]


def _row(name: str, cases: list[Case], first: list[bool], claimed: list[bool], alarms: int) -> str:
    cells = []
    for strengths in [*((s,) for s in CURVE), STRENGTHS[2:]]:
        these = [i for i, case in enumerate(cases) if case.strength in strengths]
        shares = [100 * np.mean([told[i] for i in these]) for told in (first, claimed)]
        cells.append(f"{shares[0]:.0f} ({shares[1]:.0f})")
    return f"| {name} | {' | '.join(cells)} | {alarms} |"


def _words(peer: str, setting: tuple[float, ...], least: float) -> str:
    if peer.endswith("FROLS"):
        return f"FROLS: a drop of BIC by {least:.3g}"
    if peer.endswith("STLSQ"):
        return f"STLSQ: threshold {setting[0]:g} of what the known terms leave, ridge {setting[1]:g}, a drop of BIC by {least:.3g}"
    terms = f"order {setting[0]:g}" if setting[0] else "the six terms alone"
    return f"surface: {terms}, dropped below {setting[1]:g} %, a factor of {least:.2g} %"
