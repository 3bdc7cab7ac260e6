"""Forces by chance: how much one would lower chi-square, of each draw of noise, at every place that a fit may reach.

A place is one set of inner parameters. A force of small strength there changes the readings along one direction, its
column; a state at the start of a release adds one of that release alone.
"""

from collections.abc import Sequence

import numpy as np

from identify.arrays import Array
from identify.diagnosis.null_columns import NullColumns
from identify.diagnosis.null_lines import rows_of
from identify.diagnosis.places import LINEAR_UP_TO, Places
from identify.diagnosis.weak_presence import probes
from identify.fitting.fit import Fit
from identify.fitting.problem import Problem
from identify.fitting.tangent import Tangent
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay

_AT_ONCE = 2_000_000
"""Numbers in the columns of one effect that are multiplied with the draws together."""

_MOST_COLUMN_NUMBERS = 2_000_000
_FEWEST_PLACES = 100
"""Numbers in all columns of one effect: of long records its starting values lie less close, a hundred of them at least."""

_PLACES_FAR = 12
"""Starting values of an effect at which chance is drawn where gains lie far beyond it."""

_PROBE = 1e-5
"""Share of the acceleration that a probed force has: it moves the readings by a few units of noise, in proportion.

With a hundred times as much what the fit's parameters leave is mostly of second order.
"""
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Of the way from a joint that gives way to one side at the start to one that gives way to the other."""


def force_places(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    term: Term,
    starts: tuple[dict[str, float], ...],
    tangent: Tangent,
    noise: Array,
) -> Places:
    """Return the drop of chi-square by a force at its places among `starts`, of each draw of noise (readings, draws).

    `noise` is less what the fit's parameters follow, and of the sign in which a presence lowers it.
    """
    problem = Problem(base.model.plus(term), base.windows, base.frequency, coarse=True)
    before = Problem(base.model, base.windows, base.frequency, coarse=True).residuals(base.theta)
    rows = rows_of(base.windows)
    near = max(_FEWEST_PLACES, _MOST_COLUMN_NUMBERS // len(before))
    enough = _PLACES_FAR if base.reduced > LINEAR_UP_TO else near
    kept = starts[:: (len(starts) - 1) // enough + 1]
    drops = np.zeros((len(kept), noise.shape[1]))
    one_sided, several = term.effect.one_sided, False
    waiting: dict[int, list[Array]] = {}
    for place, start in enumerate(kept):
        points = probes(decays, base, problem, term, start, _PROBE, early=True)
        if not term.force.fading_memory and len(base.windows) == 1:  # of several each has a state of its own
            waiting[place] = _held_either_way(problem, term, points, before)
        else:
            columns = NullColumns.at(problem, points, before, rows)
            if columns.own:
                several = True
                drops[place] = _together(*columns.products(tangent, noise, rows), one_sided=one_sided)
            elif columns.whole is not None:
                waiting[place] = [columns.whole]
        if sum(map(len, waiting.values())) * len(before) > _AT_ONCE:
            _of_each(waiting, tangent, noise, drops, one_sided=one_sided)
            waiting = {}
    _of_each(waiting, tangent, noise, drops, one_sided=one_sided)
    return Places(kept, drops, between=several)


def _held_either_way(problem: Problem, term: Term, points: Sequence[Array], before: Array) -> list[Array]:
    """Return what a force does (readings,) that never forgets where it came from, held on one side before, or on the other.

    It cannot be drawn farther than it yields: as a direction of its own its state would be drawn without limit.
    """
    if not points:
        return []
    states = np.array([u.id.role == "state" and u.id.effect == term.effect.name for u in problem.unknowns])
    one, other = (problem.residuals(np.where(states, side, points[0])) - before for side in (1.0, -1.0))
    if not np.isfinite(one + other).all():
        return []
    return [one + share * (other - one) for share in _SHARES]


def _of_each(
    places: dict[int, list[Array]], tangent: Tangent, noise: Array, drops: Array, *, one_sided: bool
) -> None:
    """Write the largest drop by any one of the columns (readings,) of each place into `drops` (places, draws).

    What lies between two neighbours is nearly their mean, where they have something in common.
    """
    of = [place for place, columns in places.items() for _ in columns]
    if not of:
        return
    free = tangent.free(np.column_stack([column for columns in places.values() for column in columns]))
    free /= np.sqrt(np.maximum(np.sum(free**2, axis=0), 1e-300))
    amount = free.T @ noise
    alike = np.sum(free[:, :-1] * free[:, 1:], axis=0)
    mean = np.zeros_like(amount)
    mean[:-1] = (amount[:-1] + amount[1:]) / np.sqrt(2.0 + 2.0 * np.abs(alike))[:, None]
    mean[:-1][alike <= 0.0] = 0.0
    if one_sided:
        amount, mean = np.maximum(amount, 0.0), np.maximum(mean, 0.0)
    np.maximum.at(drops, of, np.maximum(amount**2, mean**2))


def _together(together: Array, along: Array, *, one_sided: bool) -> Array:
    """Return the drop of chi-square by some columns together, (draws,).

    `together` (columns, columns) are their products, `along` (columns, draws) what of each draw lies along them.
    """
    if not len(together):
        return np.zeros(along.shape[1])
    values, vectors = np.linalg.eigh(together)
    kept = values > 1e-12 * values[-1]
    amount = (vectors[:, kept] / np.sqrt(values[kept])).T @ along
    if len(amount) == 1 and one_sided:
        amount = np.maximum(amount * np.sign(vectors[0, -1]), 0.0)
    return np.asarray(np.sum(amount**2, axis=0))
