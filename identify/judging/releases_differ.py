"""Whether releases differ in their linear spring and damper, which explains a misfit as well as a suspect may.

On a rig they do. One spring and one damper for all leave a misfit then that no effect explains. A spring and a damper of
each release's own are therefore fitted beside the model, and beside the best suspect; the gain is compared with
chance. A suspect may make releases of unlike amplitudes seem to differ: where nothing is left of it beside the best one,
they share spring and damper after all.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from identify.estimate import Estimate
from identify.fitting.baseline import Baseline, refit_at_floor
from identify.fitting.fit import Fit, fit
from identify.fitting.own_linear import with_own_linear, without_own_linear
from identify.fitting.parameter_layout import OWN_STIFFNESS
from identify.formatting import three_figures
from identify.judging.suspects import Candidate
from identify.preprocessing.fit_window import windows_by_release
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import DOUBT_AT_A_GUESS, RIVALS_WITHIN

SURE = -math.log(DOUBT_AT_A_GUESS)
"""Surprise from which on what a spring and damper of each release's own gain is no chance."""


def where_releases_differ(baseline: Baseline) -> Baseline:
    """Give each release a spring and damper of its own where that clearly lowers the misfit; else keep the baseline."""
    if not _may_differ(baseline.fit):
        return baseline
    own = of_each(baseline.fit)
    return _with(baseline, own) if surprise(baseline.fit, own) > SURE else baseline


def on_second_thought(first: Baseline, baseline: Baseline, ranked: tuple[Candidate, ...]) -> Baseline:
    """Decide again whether releases differ, now that suspects have been tried; return the baseline to search from.

    `first` is the baseline with one spring and damper for all releases.
    Where the best suspect has made the releases differ, they share spring and damper; where it leaves that they do, or is
    not distinguishable from that (3.9 nats), each has its own: that releases differ is the smaller claim.
    """
    top = ranked[0] if ranked and ranked[0].claimed else None
    if top is None:
        return baseline
    best = top.fit
    if baseline is not first:
        return first if shared_where_alike(best) is not best else baseline
    if not _may_differ(best):
        return baseline
    own = of_each(baseline.fit)
    evidence = surprise(baseline.fit, own)
    as_good = evidence > max(top.evidence - RIVALS_WITHIN, -math.log(baseline.alpha))
    differ = as_good or surprise(best, of_each(best)) > SURE
    return _with(baseline, own) if differ else baseline


def _may_differ(found: Fit) -> bool:
    several = len(windows_by_release(found.windows)) > 1
    return several and not any(window.own_linear for window in found.windows)


def _with(baseline: Baseline, own: Fit) -> Baseline:
    """Make a baseline of a fit with a spring and damper of each release's own, its noise floor decided again."""
    places = zip(baseline.decays, own.windows, strict=True)
    decays = tuple(
        replace(decay, floor_std=None, window=decay.window.with_(own_linear=window.own_linear))
        for decay, window in places
    )
    return refit_at_floor(decays, own)


def shared_where_alike(found: Fit) -> Fit:
    """Fit one spring and damper for all releases, where separate ones gain no more than chance would.

    An effect that was found since may have made the releases differ.
    """
    if not any(window.own_linear and not window.varies for window in found.windows):
        return found
    shared = fit(found.model, without_own_linear(found.windows), found.point, found.frequency, near=True)
    return shared if surprise(shared, found) <= SURE else found


def carried(whole: tuple[PreparedDecay, ...], baseline: Baseline) -> tuple[PreparedDecay, ...]:
    """Carry over to whole releases what was decided on pieces: the width of the floor, and whether releases differ."""
    own = {window.release: window.own_linear for window in baseline.fit.windows}
    return tuple(
        replace(prepared, floor_std=baseline.spread, window=prepared.window.with_(own_linear=own.get(i)))
        for i, prepared in enumerate(whole)
    )


def of_each(found: Fit) -> Fit:
    """Fit a spring and damper of each release's own, near those of all."""
    windows = with_own_linear(found.windows, found.frequency)
    return fit(found.model, windows, found.point, found.frequency, near=True)


def surprise(shared: Fit, own: Fit) -> float:
    """Return -ln of the probability that chance lowers chi-square as much as the releases' own parameters do.

    Chi-square counts in units of what that leaves, as its priors do. Where all releases are alike the drop is that of one
    number less than there are releases, for each of spring and damper.
    """
    extra = [u for u in own.unknowns if u.deviates >= 0]
    free = len(extra) - len({u.deviates for u in extra})
    if free < 1:
        return 0.0
    weight = next(w.own_linear.weight for w in own.windows if w.own_linear is not None)
    drop = max(shared.chi_square - own.chi_square, 0.0) / weight
    from scipy.special import gammaincc, gammaln  # loaded when it is needed

    tail = float(gammaincc(0.5 * free, 0.5 * drop))
    if tail > 0.0:
        return -float(np.log(tail))
    return 0.5 * drop - (0.5 * free - 1.0) * float(np.log(0.5 * drop)) + float(gammaln(0.5 * free))


_SEEN = 2.0
"""Spread of the releases, over the errors of their values, from which on it is worth a sentence."""


@dataclass(frozen=True)
class ReleaseValue:
    """A parameter of release `index`, from 0, and by how much it differs from the shared value, in % of the latter.

    The error is that of the value alone, not of how much it differs from release to release.
    """

    index: int
    parameter: str
    value: Estimate
    percent: float


def release_values(found: Fit) -> tuple[ReleaseValue, ...]:
    """List spring and damper of each release; none where all releases share them."""
    releases = [places[0] for places in windows_by_release(found.windows).values()]
    values = []
    for i, unknown in enumerate(found.unknowns):
        if unknown.deviates < 0:
            continue
        at = unknown.deviates
        shared = found.unknowns[at]
        light = found.windows[unknown.window].lightness
        variance = found.covariance[i, i] + 2.0 * found.covariance[i, at] + found.covariance[at, at]
        own = float(found.theta[i])
        values.append(
            ReleaseValue(
                releases.index(unknown.window),
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
    """Say by how much spring and damper differ between releases, with units; "" where they share them.

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
