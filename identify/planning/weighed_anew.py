"""A first answer after one more release, long before a diagnosis: each hypothesis refitted and weighed again."""

from collections.abc import Sequence
from dataclasses import replace

from identify.evidence import evidence
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import initial_nuisances, scales_of
from identify.planning.hypotheses import Hypothesis
from identify.preprocessing.prepared_decay import PreparedDecay

_LEADING = 4


def weighed_anew(
    hypotheses: Sequence[Hypothesis], decays: Sequence[PreparedDecay], new: PreparedDecay
) -> tuple[Hypothesis, ...]:
    """Refit the leading hypotheses to the releases so far and a new one, the likeliest first.

    Nothing new is looked for; a law outside the library and a random walk are left out.
    """
    whole, scales = (*decays, new), scales_of(new, {})
    windows = tuple(decay.window.with_(release=i, own_linear=None) for i, decay in enumerate(whole))
    laws = [h for h in hypotheses if h.has_law]
    least = min(laws, key=lambda one: len(one.fit.model.terms))
    refits = {}
    for one in dict.fromkeys((*laws[:_LEADING], least)):
        start = initial_nuisances(whole, one.fit.model, one.fit.point) | _shared(one.fit, len(whole))
        refits[one] = fit(one.fit.model, windows, start, one.fit.frequency, near=True, tolerance=1.0)
    found = (
        replace(one, fit=refit, free=None, log_odds=evidence(refits[least], refit, scales))
        for one, refit in refits.items()
    )
    return tuple(sorted(found, key=lambda one: -one.log_odds))


def _shared(found: Fit, releases: int) -> dict[str, float]:
    """Return the starting values of shared unknowns, and of sensors' faults, equal in each of so many releases."""
    values = {}
    for u, value in zip(found.unknowns, found.theta.tolist(), strict=True):
        if u.window < 0:
            values[u.name] = value
        elif u.window == 0 and u.id.role == "parameter":
            values |= {str(u.id.of_release(i, releases)): value for i in range(releases)}
    return values
