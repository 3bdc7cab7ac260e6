"""The worst places: where the model fails beyond the noise, each in a sentence that an engineer accepts."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement as _bands

import numpy as np

from identify.arrays import Array
from identify.comparison.compare_cycles import CycleErrors
from identify.comparison.discrepancy_text import DiscrepancyText
from identify.comparison.phase_plane import PhasePlane
from identify.comparison.residual_tone import ResidualTone

MOST = 5
NONE = "No discrepancy exceeds the noise."
_FALSE_ALARMS = 0.05
_DRAWS = 1000
_GROUPS = 6
_OVERLAP = 0.3
_SHARE_OF_WORST = 0.1
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Discrepancy:
    """One place where the model fails: `kind` says how it was seen, `size` by how much, in `unit`.

    `kind` is "force over displacement", "force over velocity", "frequency", "energy" or "line".
    `size` (measured less model; positive is stiffer, braking more, faster, losing more) is the mean over the place
    with standard error `std`; of a line it is the amplitude. `significance` is in standard errors.
    """

    kind: str
    text: str
    size: float
    std: float
    unit: str
    significance: float


@dataclass(frozen=True, eq=False)
class _Candidate:
    kind: str
    members: Array
    weights: Array
    std: float
    levels: tuple[int, int]
    side: int
    way: int


def find_discrepancies(
    plane: PhasePlane,
    cycles: CycleErrors,
    line: ResidualTone | None,
    words: DiscrepancyText,
    doubt: tuple[float, float],
) -> tuple[Discrepancy, ...]:
    """Return at most five places, the most significant first; none when nothing stands out of the noise.

    `doubt` are factors >= 1 on the standard errors of the forces and of the cycles: what is unsure about
    the noise, and what neither explains. The threshold is where the best of all candidates lies in 5 % of the cases in
    which there is noise only.
    """
    force = plane.force[plane.bins[:, 0], plane.bins[:, 1]]
    errors = np.concatenate([cycles.frequency_error, cycles.energy_error])
    plane = replace(plane, covariance=_firm(plane.covariance))
    cycles = replace(cycles, covariance=_firm(cycles.covariance))
    families = (
        (tuple(_force_candidates(plane)), force, plane.covariance, doubt[0]),
        (tuple(_cycle_candidates(cycles)), errors, cycles.covariance, doubt[1]),
    )
    found: list[tuple[float, _Candidate, Array, float]] = []
    worst_by_chance = np.zeros(_DRAWS)
    random = np.random.default_rng(20)
    for candidates, values, covariance, factor in families:
        if not candidates:
            continue
        weights = np.array([c.weights / c.std for c in candidates])
        chance = weights @ (np.linalg.cholesky(covariance) @ random.standard_normal((len(values), _DRAWS)))
        worst_by_chance = np.maximum(worst_by_chance, np.max(np.abs(chance), axis=0))
        for candidate, score in zip(candidates, weights @ values / factor, strict=True):
            found.append((float(score), candidate, values, factor))
    limit = max(float(np.quantile(worst_by_chance, 1.0 - _FALSE_ALARMS)), 3.0)
    found = [entry for entry in found if abs(entry[0]) > limit]
    found.sort(key=lambda entry: -abs(entry[0]))
    chosen: list[tuple[float, _Candidate, Array, float]] = []
    for entry in found:
        if len(chosen) == MOST or abs(entry[0]) < _SHARE_OF_WORST * abs(found[0][0]):
            break
        if not any(_same(entry[1], other[1]) for other in chosen):
            chosen.append(entry)
    places = [_described(*entry, plane, cycles, words) for entry in chosen]
    if line is not None:
        text, unit = words.at_frequency(line.frequency, line.amplitude, line.channel, line.channels)
        std = line.amplitude / line.significance
        places.append(Discrepancy("line", text, line.amplitude, std, unit, line.significance))
    places.sort(key=lambda place: -place.significance)
    return tuple(places[:MOST])


def _firm(covariance: Array) -> Array:
    """Return a covariance that can be inverted, whatever rounding has done to it."""
    std = np.sqrt(np.diag(covariance))
    eigenvalues, vectors = np.linalg.eigh(covariance / np.outer(std, std))
    return np.asarray(np.outer(std, std) * ((vectors * np.maximum(eigenvalues, _ROUNDING)) @ vectors.T))


def _same(one: _Candidate, other: _Candidate) -> bool:
    if one.kind != other.kind:
        return False
    shared = float(np.sum((one.members != 0) & (other.members != 0)))
    return bool(shared > _OVERLAP * min(np.count_nonzero(one.members), np.count_nonzero(other.members)))


def _candidate(
    kind: str, members: Array, covariance: Array, levels: tuple[int, int], side: int = 0, way: int = 0
) -> _Candidate:
    """Weigh the members (signs, 0 outside, some inside) so that their mean has the smallest error."""
    inside = np.flatnonzero(members)
    signs = members[inside]
    solved = np.linalg.solve(covariance[np.ix_(inside, inside)], signs)
    information = float(signs @ solved)
    weights = np.zeros(len(members))
    weights[inside] = solved / information
    return _Candidate(kind, members, weights, information**-0.5, levels, side, way)


def _force_candidates(plane: PhasePlane) -> Iterator[_Candidate]:
    """Bands of displacement (stiffer) and of velocity (braking), on one side or both, in one direction or both."""
    rows, columns = plane.bins[:, 0], plane.bins[:, 1]
    middle_column, middle_row = plane.force.shape[1] // 2, plane.force.shape[0] // 2
    side = np.sign(columns - middle_column)
    out = np.abs(columns - middle_column)
    way = np.where(rows >= middle_row, 1, -1)
    speed = np.where(rows >= middle_row, rows - middle_row, middle_row - 1 - rows)
    for first, last in _bands(range(1, middle_column + 1), 2):
        band = (out >= first) & (out <= last)
        for one_side in (0, 1, -1):
            for one_way in (0, 1, -1):
                kept = band & ((side == one_side) | (one_side == 0)) & ((way == one_way) | (one_way == 0))
                if (kept & (side != 0)).any():
                    place = ((first, last), one_side, one_way)
                    yield _candidate("force over displacement", kept * side, plane.covariance, *place)
    for first, last in _bands(range(middle_row), 2):
        band = (speed >= first) & (speed <= last)
        for one_way in (0, 1, -1):
            kept = band & ((way == one_way) | (one_way == 0))
            if kept.any():
                yield _candidate(
                    "force over velocity", kept * way, plane.covariance, (first, last), 0, one_way
                )


def _cycle_candidates(cycles: CycleErrors) -> Iterator[_Candidate]:
    count = len(cycles.time)
    edges = np.unique(np.linspace(0, count, min(_GROUPS, count) + 1).astype(int))
    for first, last in _bands(range(len(edges) - 1), 2):
        for shift, kind in ((0, "frequency"), (count, "energy")):
            members = np.zeros(2 * count)
            members[shift + edges[first] : shift + edges[last + 1]] = 1.0
            yield _candidate(kind, members, cycles.covariance, (edges[first], edges[last + 1] - 1))


def _described(
    score: float,
    candidate: _Candidate,
    values: Array,
    factor: float,
    plane: PhasePlane,
    cycles: CycleErrors,
    words: DiscrepancyText,
) -> Discrepancy:
    size = float(candidate.weights @ values)
    low, high = candidate.levels
    if candidate.kind.startswith("force"):
        across = candidate.kind == "force over displacement"
        edges = plane.displacement_edges if across else plane.velocity_edges
        middle = (len(edges) - 1) // 2
        at = (float(edges[middle + low]), float(edges[middle + high + 1]))
        text, scale, unit = words.over_force(candidate.kind, size, at, candidate.side, candidate.way)
    else:
        times = (float(cycles.time[low]), float(cycles.time[high]))
        amplitudes = (
            float(np.min(cycles.amplitude[low : high + 1])),
            float(np.max(cycles.amplitude[low : high + 1])),
        )
        text, scale, unit = words.over_cycles(candidate.kind, size, times, amplitudes)
    return Discrepancy(candidate.kind, text, scale * size, scale * candidate.std * factor, unit, abs(score))
