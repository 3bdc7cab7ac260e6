"""The null distribution: how much each suspect would lower chi-square if nothing were missing.

Under the present model the readings differ from the prediction by noise alone. A suspect of small strength changes the
prediction along one direction (its column) for each value of its inner parameters; what the fit's own parameters can
follow is projected out. For drawn noise, the best drop of chi-square over the suspect's columns is a draw from its null
distribution, and the smallest tail probability over the whole library one from that of the search. A force is one for
all releases; a sensor's fault has parameters in each, whose drops add up.
"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.diagnosis.null_columns import NullColumns
from identify.diagnosis.null_lines import line_drops, rows_of
from identify.diagnosis.weak_presence import probes, with_fault
from identify.effects.effect import Scales
from identify.fitting.fit import Fit
from identify.fitting.initial_values import scales_of, term_starts
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem
from identify.fitting.tangent import Tangent
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay

_DRAWS = 400
_FEWEST_DRAWS = 100
_MOST_NUMBERS = 4_000_000
"""Random numbers that are drawn: of records of more than 10,000 readings there are fewer draws, 100 at least."""

_AT_ONCE = 2_000_000
"""Numbers in the columns of one effect that are multiplied with the draws together."""

_MOST_COLUMN_NUMBERS = 2_000_000
_FEWEST_PLACES = 100
"""Numbers in all columns of one effect: of long records its starting values lie less close, a hundred of them at least."""

_PROBE = 1e-3
_TAIL = 0.1

_STRENGTH_SEED = 1
_WEAKEST = 0.1
"""Least strength of drawn noise, in units of the floor, however unsure that is."""


@dataclass(frozen=True, eq=False)
class NullDistribution:
    """Null distributions of the drop of chi-square, by effect name, and of the search over all of them.

    `drops` maps an effect to its draws, sorted; `search` holds the largest surprise (-ln p) of each draw over
    the library, sorted.
    """

    drops: dict[str, Array]
    search: Array

    def surprise(self, effect: str, drop: float) -> float:
        """Return -ln of the probability that chance lowers chi-square this much by this effect alone."""
        return float(_surprise(self.drops[effect], np.array([drop]))[0]) if effect in self.drops else 0.0

    def p_value(self, effect: str, drop: float) -> float:
        """Return the probability that chance gives any suspect in the library as good a reason."""
        surprise = self.surprise(effect, drop)
        return float(np.exp(-_surprise(self.search, np.array([surprise]), slope=1.0)[0]))


def null_distribution(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    terms: tuple[Term, ...],
    *,
    unsure: tuple[dict[str, float], ...] = (),
    seed: int = 0,
    draws: int = _DRAWS,
) -> NullDistribution:
    """Draw what each suspect would gain by chance; the same seed gives the same draws.

    `unsure` is the relative standard error of each channel's noise in each window: it may be so much stronger or weaker
    than the floor that gains are measured in. None where the noise is known.
    """
    readings = sum(int(mask.sum()) for window in base.windows for mask in window.used.values())
    draws = min(draws, max(_FEWEST_DRAWS, _MOST_NUMBERS // max(readings, 1)))
    random = np.random.default_rng(seed)
    theta = base.theta
    problem = Problem(base.model, base.windows, base.frequency)
    _, jacobian = linearise(problem, theta)
    noise = np.concatenate(
        [window.draw_noise(channel, random, draws) for window in base.windows for channel in window.channels]
    )
    if unsure:
        noise *= _strengths(base, unsure, draws)
    low, high = theta <= problem.low, theta >= problem.high
    tangent = jacobian.tangent(~(low | high))
    for at, side in [
        *((j, 1.0) for j in np.flatnonzero(low).tolist()),
        *((j, -1.0) for j in np.flatnonzero(high).tolist()),
    ]:
        noise = _pressed(noise, side * jacobian.column(at), tangent)
    free = tangent.free(noise)
    scales = scales_of(decays[0], dict.fromkeys(base.windows[0].channels, ()))
    drops: dict[str, Array] = {}
    for term in terms:
        name = term.effect.name
        if term.effect.line:
            best = line_drops(base, term, noise)
        elif term.is_force:
            best = _column_drops(decays, base, term, scales, tangent, free)
        else:
            best = _fault_drops(base, term, scales, tangent, free)
        drops[name] = np.maximum(drops[name], best) if name in drops else best
    search = np.max([_surprise(np.sort(d), d) for d in drops.values()], axis=0)
    return NullDistribution({name: np.sort(d) for name, d in drops.items()}, np.sort(search))


def _strengths(base: Fit, unsure: tuple[dict[str, float], ...], draws: int) -> Array:
    """Return how strong the noise of each reading may be in units of the floor, (readings, draws).

    A channel's error is one in all windows: they share their sensor, and most of them their rest.
    """
    random = np.random.default_rng(_STRENGTH_SEED)
    drawn: dict[str, Array] = {}
    rows = []
    for window, relative in zip(base.windows, unsure, strict=True):
        for channel in window.channels:
            if channel not in drawn:
                drawn[channel] = random.standard_normal(draws)
            strength = np.maximum(1.0 + relative.get(channel, 0.0) * drawn[channel], _WEAKEST)
            rows.append(np.broadcast_to(strength, (int(window.used[channel].sum()), draws)))
    return np.concatenate(rows)


def _pressed(noise: Array, column: Array, tangent: Tangent) -> Array:
    """Return the draws under which a parameter at its bound would stay there: those that lift it are mirrored.

    `column` is how the misfit changes as the parameter moves into its range.
    """
    free = tangent.free(column)
    size = float(np.linalg.norm(free))
    if not size > 1e-9 * float(np.linalg.norm(column)):
        return noise
    direction = free / size
    lifted = np.minimum(direction @ noise, 0.0)
    return noise - 2.0 * np.outer(direction, lifted)


def _surprise(draws: Array, values: Array, slope: float = 0.5) -> Array:
    """Return -ln of the tail probability; beyond the last tenth of the draws it grows with the given slope."""
    n = len(draws)
    knee = draws[int((1.0 - _TAIL) * n)]
    rank = np.searchsorted(draws, values, side="left")
    inside = np.minimum(-np.log((n - rank + 0.5) / (n + 0.5)), -np.log(_TAIL))
    return np.asarray(np.where(values > knee, -np.log(_TAIL) + slope * (values - knee), inside))


def _column_drops(
    decays: tuple[PreparedDecay, ...], base: Fit, term: Term, scales: Scales, tangent: Tangent, noise: Array
) -> Array:
    problem = Problem(base.model.plus(term), base.windows, base.frequency, coarse=True)
    before = Problem(base.model, base.windows, base.frequency, coarse=True).residuals(base.theta)
    rows = rows_of(base.windows)
    best, one_sided = np.zeros(noise.shape[1]), term.effect.one_sided
    single: list[Array] = []
    starts = term_starts(term, scales, fine=True)
    enough = max(_FEWEST_PLACES, _MOST_COLUMN_NUMBERS // len(before))
    for start in starts[:: (len(starts) - 1) // enough + 1]:
        columns = NullColumns.at(problem, probes(decays, base, problem, term, start, _PROBE), before, rows)
        if columns.own:
            drops = _drops(*columns.products(tangent, noise, rows), one_sided=one_sided)
            best = np.maximum(best, drops)
        elif columns.whole is not None:
            single.append(columns.whole)
        if len(single) * len(before) > _AT_ONCE:
            best, single = np.maximum(best, _best_of(single, tangent, noise, one_sided=one_sided)), []
    return np.maximum(best, _best_of(single, tangent, noise, one_sided=one_sided)) if single else best


def _best_of(columns: list[Array], tangent: Tangent, noise: Array, *, one_sided: bool) -> Array:
    """Return the largest drop of chi-square by any one of some columns (readings,), of each draw, (draws,)."""
    free = tangent.free(np.column_stack(columns))
    amount = (free / np.sqrt(np.maximum(np.sum(free**2, axis=0), 1e-300))).T @ noise
    return np.asarray(np.max(np.maximum(amount, 0.0) ** 2 if one_sided else amount**2, axis=0))


def _drops(together: Array, along: Array, *, one_sided: bool) -> Array:
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


def _fault_drops(base: Fit, term: Term, scales: Scales, tangent: Tangent, noise: Array) -> Array:
    """Sum over the releases of the best drop by a fault that each has with parameters of its own."""
    problem = Problem(base.model.plus(term), base.windows, base.frequency)
    before = Problem(base.model, base.windows, base.frequency).residuals(base.theta)
    changes = [
        problem.residuals(problem.theta(with_fault(base, term, start))) - before
        for start in term_starts(term, scales, fine=True)
    ]
    changes = [change for change in changes if np.isfinite(change).all()]
    total = np.zeros(noise.shape[1])
    for i, rows in enumerate(rows_of(base.windows)):
        amounts = _amounts([change[rows] for change in changes], tangent.part(i), noise[rows])
        if not amounts:
            continue
        if term.fault.held_at_first:
            one_sided = term.effect.strength.low >= 0.0
            total += np.max([np.maximum(a, 0.0) ** 2 if one_sided else a**2 for a, _ in amounts], axis=0)
        else:  # the starts are directions, all of which are free
            total += np.sum([free**2 for _, free in amounts], axis=0)
    return total


def _amounts(columns: list[Array], tangent: Array, noise: Array) -> list[tuple[Array, Array]]:
    """Return how much of each draw lies along each column, (draws,) each, and along what earlier columns leave of it.

    Columns (readings,) are those of one release, less what the fit's parameters follow in all of them; of the noise that
    is left out already.
    """
    if not columns:
        return []
    design = np.column_stack(columns)
    own = tangent.T @ design
    together = design.T @ design - own.T @ own
    along = design.T @ noise
    size = np.diag(together)
    kept = [j for j in range(len(columns)) if size[j] > 1e-18 + 1e-12 * float(columns[j] @ columns[j])]
    scale = np.sqrt(size[kept])
    together = together[np.ix_(kept, kept)] / np.outer(scale, scale)
    along = along[kept] / scale[:, None]
    found: list[tuple[Array, Array]] = []
    basis: list[Array] = []
    for j in range(len(kept)):
        left = np.zeros(len(kept))
        left[j] = 1.0
        for other in basis:
            left = left - float(left @ together @ other) * other
        length = float(np.sqrt(max(float(left @ together @ left), 0.0)))
        free = np.zeros(noise.shape[1])
        if length > 1e-4:
            basis.append(left / length)
            free = basis[-1] @ along
        found.append((along[j], free))
    return found
