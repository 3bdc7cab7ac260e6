"""The linear spring and damper of each release, where releases that are fitted together have their own."""

from dataclasses import dataclass

import numpy as np

from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.fitting.parameter_layout import OWN_STIFFNESS, windows_by_release
from identify.formatting import three_figures

_SEEN = 2.0
"""Spread of the releases, over the errors of their values, from which on it is worth a sentence."""


@dataclass(frozen=True)
class ReleaseValue:
    """A parameter as it is in release `index`, from 0, and by how much it differs from that of all, in % of the latter.

    The error is that of the value alone, not of how much it differs from release to release.
    """

    index: int
    parameter: str
    value: Estimate
    percent: float


def release_values(found: Fit) -> tuple[ReleaseValue, ...]:
    """Return spring and damper of each release; none where all releases share them."""
    releases = [places[0] for places in windows_by_release(found.windows).values()]
    values = []
    for i, unknown in enumerate(found.unknowns):
        if unknown.deviates < 0:
            continue
        at = unknown.deviates
        shared = found.unknowns[at]
        light = found.windows[unknown.moves[0]].lightness
        variance = found.covariance[i, i] + 2.0 * found.covariance[i, at] + found.covariance[at, at]
        own = float(found.theta[i])
        values.append(
            ReleaseValue(
                releases.index(unknown.moves[0]),
                shared.name,
                Estimate(
                    light * max(float(found.theta[at]) + own, shared.low),
                    light * float(np.sqrt(max(variance, 0.0))),
                    shared.unit,
                ),
                100.0 * own / float(found.theta[at]) if found.theta[at] else float("inf"),
            )
        )
    return tuple(sorted(values, key=lambda one: (one.index, one.parameter)))


def spread_sentence(found: Fit) -> str:
    """Return by how much spring and damper differ between releases, with units; "" where they share them.

    The numbers are standard deviations between releases.
    """
    clauses = []
    for at in sorted({u.deviates for u in found.unknowns if u.deviates >= 0}):
        own = [i for i, u in enumerate(found.unknowns) if u.deviates == at]
        spread = float(np.std(found.theta[own], ddof=1)) if len(own) > 1 else 0.0
        if spread <= _SEEN * float(np.sqrt(np.mean(np.diag(found.covariance)[own]))):
            continue
        name = "spring" if found.unknowns[own[0]].id.parameter == OWN_STIFFNESS else "viscous damping"
        mean, unit = float(found.theta[at]), found.unknowns[at].unit
        share = f"{three_figures(100.0 * spread / mean)} % " if mean > 0.0 else ""
        size = f"±{three_figures(spread)} {unit}"
        clauses.append(f"the {name} differs by {f'±{share}({size})' if share else size}")
    if not clauses:
        return ""
    return f"Between releases {' and '.join(clauses)}; each has its own."
