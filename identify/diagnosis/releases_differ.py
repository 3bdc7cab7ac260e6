"""Whether releases differ in their linear spring and damper: as good a reason for a misfit as a suspect.

On a rig they do. One spring and one damper for all leave a misfit then that no effect explains. A spring and a damper of
each release's own are therefore fitted to what the usual model leaves, and to what the best suspect leaves; what they
gain is held against chance, and against what the best suspect gains.
"""

from dataclasses import replace

import numpy as np
from scipy.special import gammaincc, gammaln

from identify.diagnosis.ranking import Ranked
from identify.fitting.baseline import Baseline, refit_at_floor
from identify.fitting.fit import Fit, fit
from identify.fitting.own_linear import with_own_linear, without_own_linear
from identify.fitting.parameter_layout import windows_by_release

CLEARLY = 1e-4
"""Probability below which what a spring and damper of each release's own gain is no chance."""


def where_releases_differ(baseline: Baseline, ranked: tuple[Ranked, ...]) -> Baseline:
    """Return the baseline with a spring and damper of each release's own where they differ; the same where they do not.

    They do where that has more evidence than any suspect of one spring and damper for all, or where the best suspect
    leaves it.
    """
    found = baseline.fit
    if len(windows_by_release(found.windows)) < 2 or any(w.own_linear for w in found.windows):
        return baseline
    own = of_each(found)
    evidence = surprise(found, own)
    top = ranked[0] if ranked and ranked[0].claimed else None
    if top is None or evidence > top.evidence:
        differ = evidence > -np.log(CLEARLY)
    else:
        best = top.candidate.fit
        differ = surprise(best, of_each(best)) > -np.log(CLEARLY)
    if not differ:
        return baseline
    places = zip(baseline.decays, own.windows, strict=True)
    decays = tuple(
        replace(decay, floor_std=None, window=decay.window.with_(own_linear=window.own_linear))
        for decay, window in places
    )
    return refit_at_floor(decays, own).decided


def shared_where_alike(found: Fit) -> Fit:
    """Return a fit with one spring and damper for all releases, where those of their own gain no more than by chance.

    What made the releases differ may have been what was found since.
    """
    if not any(window.own_linear for window in found.windows):
        return found
    shared = fit(found.model, without_own_linear(found.windows), found.point, found.frequency, near=True)
    return shared if surprise(shared, found) <= -np.log(CLEARLY) else found


def of_each(found: Fit) -> Fit:
    """Return a fit with a spring and damper of each release's own, near those of all."""
    windows = with_own_linear(found.windows, found.frequency)
    return fit(found.model, windows, found.point, found.frequency, near=True)


def surprise(shared: Fit, own: Fit) -> float:
    """Return -ln of the probability that chance lowers chi-square as much as what each release has of its own does.

    Chi-square counts in units of what that leaves, as its priors do. Where all releases are alike the drop is that of one
    number less than there are releases, for each of spring and damper.
    """
    extra = [u for u in own.unknowns if u.deviates >= 0]
    free = len(extra) - len({u.deviates for u in extra})
    if free < 1:
        return 0.0
    weight = next(w.own_linear.weight for w in own.windows if w.own_linear is not None)
    drop = max(shared.chi_square - own.chi_square, 0.0) / weight
    tail = float(gammaincc(0.5 * free, 0.5 * drop))
    if tail > 0.0:
        return -float(np.log(tail))
    return 0.5 * drop - (0.5 * free - 1.0) * float(np.log(0.5 * drop)) + float(gammaln(0.5 * free))
