"""What the peers name on the same records: PySINDy's optimisers, and polynomial surfaces with significance factors."""

import warnings
from collections import Counter, defaultdict

import numpy as np

from bench.diagnosis import BASE, EFFECTS, STRENGTHS, Case, judge_all, setting_of
from identify.effects.library import LIBRARY
from identify.equation_error import force_along, moving
from identify.errors import NotIdentifiable
from identify.model import Term
from identify.setting import Setting, scales_of, term_starts

TITLE = "Peers on the same records"
NO_COLUMN = ("hysteresis", "maxwell_element", "second_mass", "harmonic_forcing")
_POLYNOMIALS = {
    "quadratic_stiffness": (2, 0),
    "cubic_stiffness": (3, 0),
    "quintic_stiffness": (5, 0),
    "quadratic_damping": (0, 2),
    "cubic_damping": (0, 3),
    "position_dependent_damping": (2, 1),
}


def columns_of(setting: Setting) -> tuple[list[str], np.ndarray]:
    """Return the columns that a library of functions of u, v, t can have, and the effect that each stands for."""
    motion = setting.motion
    scales = scales_of(setting, {})
    names, columns = [], []
    for effect in LIBRARY:
        if effect.kind != "physics" or effect.name in NO_COLUMN:
            continue
        for variant in effect.variants:
            term = Term(effect, variant)
            for start in term_starts(term, scales) if effect.name not in BASE else ({},):
                inner = {key.split(".")[1]: value for key, value in start.items()}
                borrowed = {"linear_stiffness.k": setting.frequency**2}
                columns.append(
                    force_along(term, inner, setting.time, motion.displacement, motion.velocity, borrowed)
                )
                names.append(effect.name)
    return names, np.column_stack([*columns, np.ones(len(columns[0]))])


def _prepared(setting: Setting) -> tuple[list[str], np.ndarray, np.ndarray, np.ndarray]:
    """Return names, candidate columns and target with the known terms pinned (projected out), masked, normalised."""
    names, table = columns_of(setting)
    used = moving(setting.motion)
    target = -setting.motion.acceleration[used]
    table = table[used]
    known = [i for i, n in enumerate(names) if n in BASE] + [table.shape[1] - 1]
    basis = np.linalg.qr(table[:, known])[0]
    rest = [i for i, n in enumerate(names) if n not in BASE]
    left = table[:, rest] - basis @ (basis.T @ table[:, rest])
    left = left / np.maximum(np.linalg.norm(left, axis=0), 1e-300)
    return [names[i] for i in rest], left, target - basis @ (basis.T @ target), table


def frols(setting: Setting) -> str:
    """Name what forward regression (FROLS) picks first, if it lowers BIC."""
    import pysindy

    names, columns, target, _ = _prepared(setting)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = pysindy.FROLS(max_iter=1, alpha=1e-12).fit(columns, target[:, None])
    return _judged(names, columns, target, np.abs(found.coef_[0]))


def stlsq(setting: Setting) -> str:
    """Name the largest term that sequentially thresholded least squares (STLSQ) keeps, if it lowers BIC."""
    import pysindy

    names, columns, target, _ = _prepared(setting)
    size = float(np.linalg.norm(target))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = pysindy.STLSQ(threshold=0.3 * size, alpha=1e-3).fit(columns, target[:, None])
    return _judged(names, columns, target, np.abs(found.coef_[0]))


def _judged(names: list[str], columns: np.ndarray, target: np.ndarray, weights: np.ndarray) -> str:
    if not np.any(weights > 0.0):
        return "none"
    best = int(np.argmax(weights))
    explained = float(columns[:, best] @ target) ** 2
    total = float(target @ target)
    gain = len(target) * np.log(total / max(total - explained, 1e-300)) - np.log(len(target))
    return names[best] if gain > 12.0 else "none"


def significance(setting: Setting) -> str:
    """Name the polynomial term with the largest significance factor (eq. 19) above 0.001 %."""
    motion = setting.motion
    used = moving(motion)
    u, v = motion.displacement[used], motion.velocity[used]
    base = [u, v, np.sign(v), np.ones_like(u)]
    extra = {n: u**i * (v * np.abs(v) if j == 2 else v**j) for n, (i, j) in _POLYNOMIALS.items()}
    table = np.column_stack([*base, *extra.values()])
    target = -motion.acceleration[used]
    size = np.linalg.norm(table, axis=0)
    weights = np.linalg.lstsq(table / size, target, rcond=None)[0] / size
    factors = {
        n: 100.0 * np.var(c * w) / np.var(target)
        for (n, c), w in zip(extra.items(), weights[4:], strict=True)
    }
    best = max(factors, key=lambda n: factors[n])
    return best if factors[best] > 1e-3 else "none"


PEERS = {"PySINDy FROLS": frols, "PySINDy STLSQ": stlsq, "polynomial surface, significance": significance}


def run(quick: bool) -> str:
    """Return the table as markdown."""
    seeds = 1 if quick else 4
    cases = [Case(e, s, 1000 + i) for e in EFFECTS for s in STRENGTHS for i in range(seeds)]
    named: dict[str, Counter[float]] = defaultdict(Counter)
    alarms: Counter[str] = Counter()
    for case in cases:
        try:
            setting = setting_of(case)[0]
        except (NotIdentifiable, ValueError):
            continue
        for peer, judge in PEERS.items():
            named[peer][case.strength] += judge(setting) == case.hidden
    nothing = 10 if quick else 40
    for i in range(nothing):
        setting = setting_of(Case(None, 0.0, 5000 + i))[0]
        for peer, judge in PEERS.items():
            alarms[peer] += judge(setting) != "none"
    lines = [
        "| | "
        + " | ".join(f"{100 * s:g} %" for s in STRENGTHS)
        + f" | claimed with nothing hidden, of {nothing} |",
        "|---|" + "---|" * (len(STRENGTHS) + 1),
    ]
    per = len(EFFECTS) * seeds
    for peer in PEERS:
        lines.append(
            f"| {peer} | "
            + " | ".join(f"{100 * named[peer][s] / per:.0f}" for s in STRENGTHS)
            + f" | {alarms[peer]} |"
        )
    if quick:
        ours = judge_all(cases)
        share = [
            100 * np.mean([o.first == o.case.hidden for o in ours if o.case.strength == s]) for s in STRENGTHS
        ]
        lines.append("| the station | " + " | ".join(f"{x:.0f}" for x in share) + " | |")
    return (
        f"Named first, % of {per} records a strength (16 effects, {seeds} seeds, the very records of the section on naming):\n\n"
        + "\n".join(lines)
        + "\n\nThe peers get the station's own aligned motion, the known terms projected out, small speeds masked and columns at "
        "the station's starting values; a term counts when it lowers BIC by 12. Memory, second mass and forcing are no columns."
    )
