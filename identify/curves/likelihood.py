"""The marginal likelihood of a decay's curves: how probable they are under some laws, whatever else the rig does.

All that is not known is a column with a normal prior, or a part of the noise, and integrates to a closed form (a linear
mixed model; Rasmussen and Williams 2006, eq. 2.43):

    log amplitude, phase, centre = start + base + laws + a law outside the library + random walks of damper, spring + noise

Every hypothesis has the walks and the law outside the library. So a name has to beat three things at once: no effect, a
drifting rig, and an unknown law. The sizes of the walks and of that law are chosen for each hypothesis, at a price.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from scipy.linalg import LinAlgError, cholesky, solve_triangular

from identify.arrays import Array
from identify.curves.curve_laws import CurveLaws, Signals
from identify.curves.rig_noise import CENTRE, RigNoise, nameless_shapes, overlap_of
from identify.priors import FLAT, NAMELESS_IS, NOISE, SAME, SIZES, STRENGTHS, WALKS_ARE

_ROUNDS = 6
_RIDGE = 1e-12
"""Added to a correlation matrix, so that it has a root."""

Settings = tuple[int, ...]
"""Places in SIZES, by channel: of its walk and of its law outside the library."""

Part = tuple[int, slice]
"""A release, and some of its points."""


@dataclass(frozen=True)
class Added:
    """Laws beside the base, `scales` being the standard deviations of their strengths; some are `tied` to the spring's."""

    laws: tuple[int, ...] = ()
    scales: tuple[float, ...] = ()
    tied: tuple[int, ...] = ()

    def and_law(self, column: int, scale: float, *, tied: bool = False) -> "Added":
        """Return these laws and one more."""
        return Added((*self.laws, column), (*self.scales, scale), (*self.tied, column) if tied else self.tied)


@dataclass(frozen=True, eq=False)
class CurveFit:
    """Laws fitted to curves, with the log marginal likelihood (nats) and the likeliest strengths.

    `shared` (columns of base and laws,) are those of all releases, `strengths` (releases, columns) those of each.
    `dropped` are the places of those that would be out of bounds, and are none.
    """

    added: Added
    nats: float
    settings: Settings
    shared: Array
    strengths: Array
    dropped: tuple[int, ...] = ()

    @property
    def possible(self) -> bool:
        """Whether no added law is out of bounds."""
        return all(place < len(self.shared) - len(self.added.laws) for place in self.dropped)

    @property
    def with_last_alone(self) -> "CurveFit":
        """The same with the last of the added laws alone, and the strengths that were found for it and the base."""
        added, kept = self.added, [*range(len(self.shared) - len(self.added.laws)), -1]
        last = Added().and_law(added.laws[-1], added.scales[-1], tied=added.laws[-1] in added.tied)
        return replace(self, added=last, shared=self.shared[kept], strengths=self.strengths[:, kept])


@dataclass(frozen=True, eq=False)
class Products:
    """Products of the whitened columns `used`, own springs and dampers, nameless laws, and observations of some `parts`."""

    of: "CurveLikelihood"
    observed: tuple[Signals, ...]
    used: tuple[int, ...]
    noise: tuple[float, ...]
    parts: tuple[Part, ...]
    scatter: float = 0.0
    made: dict[tuple[int, int, float, float], tuple[Array, float]] = field(default_factory=dict)
    summed: dict[tuple[Settings, tuple[float, ...]], tuple[Array, float]] = field(default_factory=dict)
    beside: dict[tuple[Added, tuple[int, ...], Settings], Array] = field(default_factory=dict)

    def __call__(self, channel: int, walk: int) -> tuple[Array, float]:
        """Return the products and the logarithm of the noise's determinant, for one size of the walk."""
        key = channel, walk, self.noise[channel], self.noise[-1]
        if key not in self.made:
            self.made[key] = self._make(channel, float(SIZES[walk]))
        return self.made[key]

    def joined(self, laws: Sequence[int], settings: Settings) -> tuple[Array, float]:
        """Add the products of all channels, and the logarithms of their noise's determinants.

        In this order: some of `used` by their places, own springs and dampers, nameless laws by channel, observations.
        """
        key = settings[::2], self.noise
        if key not in self.summed:
            products, determinants = zip(*(self(*one) for one in enumerate(settings[::2])), strict=True)
            self.summed[key] = sum(products), sum(determinants)
        total, determinant = self.summed[key]
        at = np.array([*laws, *range(len(self.used), len(total))])
        return total[at[:, None], at], determinant

    def _make(self, channel: int, walk: float) -> tuple[Array, float]:
        of, laws, own = self.of, 1 + len(self.used), len(self.of.own)
        nameless = laws + own * len(of.rigs)
        total = nameless + of.nameless * len(of.channels)
        nameless += of.nameless * channel
        products, determinant = np.zeros((total, total)), 0.0
        for i, part in self.parts:
            columns = of.laws.columns[i][channel][part]
            design = np.zeros((len(columns), total + 1))
            design[:, 0] = 1.0
            design[:, 1:laws] = columns[:, list(self.used)]
            for j, (column, varies) in enumerate(of.own):
                design[:, laws + i * own + j] = columns[:, column] * varies
            design[:, nameless : nameless + of.nameless] = of.shapes[i][channel][part]
            design[:, -1] = self.observed[i][channel][part]
            rig = of.rigs[i]
            covariance = (
                rig.drifting(channel, self.scatter)
                if self.scatter
                else rig.covariance(channel, self.noise, walk)
            )
            factor = cholesky(covariance[part, part], lower=True)
            white = solve_triangular(factor, design, lower=True, check_finite=False)
            start = white[:, :1]  # the start is free
            power = float(np.sum(start**2))
            rest = white[:, 1:] - start * (start.T @ white[:, 1:]) / power
            products += rest.T @ rest
            determinant += 2.0 * float(np.sum(np.log(np.diag(factor)))) + float(np.log(power))
        return products, determinant


class CurveLikelihood:
    """The likelihood of curves under the base of their laws and under laws beside it.

    `noise` is relative to the amplitude for each channel (to the largest for the centre), and last absolute; `shapes` are
    the effects on each curve of laws outside the library, `nameless` of them.
    """

    def __init__(self, laws: CurveLaws) -> None:
        self.laws = laws
        self.base = tuple(range(laws.base))
        self.own = laws.linear if len(laws.curves) > 1 else ()
        self.rigs = tuple(RigNoise(one.curve, overlap_of(one.mode), laws.frequency) for one in laws.releases)
        grid, shapes = nameless_shapes(laws.curves)
        self.nameless = shapes.shape[1]
        self.shapes = tuple(rig.nameless(grid, shapes) for rig in self.rigs)
        self.channels = tuple(range(CENTRE + all(curve.has_centre for curve in laws.curves)))
        self._smallest = min(float(curve.amplitude.min()) for curve in laws.curves)
        self.observed = laws.measured
        self._begin: Settings = (4, 0, 4, 0, 0, 0)[: 2 * len(self.channels)]
        self.noise = self._noise_at((len(NOISE) // 2,) * (len(self.channels) + 1))
        self.observed = laws.observed(self.base, self.usual().strengths)
        self._fit_noise()

    def products(
        self,
        observed: tuple[Signals, ...],
        columns: Iterable[int],
        parts: Sequence[Part] = (),
        scatter: float = 0.0,
    ) -> Products:
        """Compute the products from which hypotheses about some columns are solved, on all points or on some parts.

        The noise is the likeliest, or, above 0, a `scatter` of the amplitude (m or rad) and a drift beside it.
        """
        parts = tuple(parts) or tuple((i, slice(None)) for i in range(len(self.rigs)))
        return Products(self, observed, tuple(sorted({*self.base, *columns})), self.noise, parts, scatter)

    def usual(self) -> CurveFit:
        """Fit the base alone."""
        return self.fitted(self.products(self.observed, self.base), Added(), self._begin, climb=True)

    def columns(self, added: Added) -> tuple[int, ...]:
        """Return the columns of the base and of laws beside it."""
        return (*self.base, *added.laws)

    def with_law(self, products: Products, before: CurveFit, column: int) -> CurveFit:
        """Fit one more law, with the likeliest scale of its strength.

        Gravity may be the whole spring, and has no constant of its own then.
        """
        at = products.used.index(column)

        def nats(settings: Settings) -> float:
            return float(self._beside(products, before, settings)[at].max())

        damper, _, spring, *others = before.settings  # it may explain a walk of either
        begins = ((a, before.settings[1], b, *others) for a in {0, damper} for b in {0, spring})
        _, settings = max(_climb(nats, begin) for begin in begins)
        size = STRENGTHS[np.argmax(self._beside(products, before, settings)[at])]
        added = before.added.and_law(column, float(size * self.laws.natural[column]))
        found = self.fitted(products, added, settings)
        if found.dropped != before.dropped:  # then other walks may be likelier
            found = self.fitted(products, added, settings, climb=True)
        if self.laws.spring_of(column) is None:
            return found
        tied = before.added.and_law(column, SAME * self.laws.frequency**2, tied=True)
        return max(found, self.fitted(products, tied, settings, climb=True), key=lambda one: one.nats)

    def _beside(self, products: Products, before: CurveFit, settings: Settings) -> Array:
        """Return the log marginal likelihood of a fit with each used law more, at each of STRENGTHS, (laws, strengths).

        With the factor of the fit's own system at hand, one more column of it costs a product.
        """
        key = (before.added, before.dropped, settings)
        if key not in products.beside:
            normal, aim, size, _ = self._system(products, before.added, settings)
            scale = self._scales(before.added, settings) / np.sqrt(size)
            mine = self._places(products, before.added)
            joined, _ = products.joined([*mine, *range(len(products.used))], settings)
            more = slice(len(mine), len(mine) + len(products.used))
            cross = np.delete(joined[:, more], more, axis=0)[:-1] * scale[:, None]
            own, along = np.diag(joined)[more], joined[more, -1]

            def free(dropped: tuple[int, ...]) -> tuple[Array, Array]:
                solved = _solution(normal, np.column_stack([cross, aim]), dropped)
                return own - np.sum(cross * solved[:, :-1], axis=0), along - cross.T @ solved[:, -1]

            (width, _), (left, sought) = free(()), free(before.dropped)
            scale = (STRENGTHS * self.laws.natural[list(products.used), None]) ** 2
            explained = scale * sought[:, None] ** 2 / (1.0 + scale * left[:, None])
            volume = np.log1p(scale * np.maximum(width, 0.0)[:, None])
            nats = self._nats(products, before.added, settings, before.dropped)
            products.beside[key] = nats + 0.5 * (explained - volume)
        return products.beside[key]

    def with_own_corrections(self, before: CurveFit, found: CurveFit) -> CurveFit:
        """Fit the last law again to curves that are corrected for windows and averaging by its own motion."""
        observed = self.laws.observed(self.columns(found.added), found.strengths)
        return self.with_law(self.products(observed, found.added.laws), before, found.added.laws[-1])

    def fitted(
        self, products: Products, added: Added, settings: Settings, *, climb: bool = False
    ) -> CurveFit:
        """Fit laws at given sizes of walks and laws outside the library, or (`climb`) at the likeliest, all within bounds.

        What would be negative is left out; a hypothesis of which an added law is left out is not possible.
        """
        columns, dropped = list(self.columns(added)), list[int]()
        low, linear = self.laws.low[columns], [column for column, _ in self.laws.linear]
        while True:
            held = tuple(dropped)

            def nats(places: Settings, held: tuple[int, ...] = held) -> float:
                return self._nats(products, added, places, held)

            most, settings = _climb(nats, settings) if climb else (nats(settings), settings)
            shared, each = self._solved(products, added, settings, held)
            wrong = [j for j in range(len(columns)) if shared[j] < low[j] - 1e-12 and j not in dropped]
            if not wrong:
                found = CurveFit(added, most, settings, shared, each, held)
                return found if found.possible else replace(found, nats=-np.inf)
            dropped.append(min(wrong, key=lambda j: columns[j] in linear))

    def _nats(
        self, products: Products, added: Added, settings: Settings, dropped: tuple[int, ...] = ()
    ) -> float:
        """Return the log marginal likelihood; `dropped` unknowns are zero but still count as unknown."""
        normal, aim, size, left = self._system(products, added, settings)
        explained = float(aim @ _solution(normal, aim, dropped))
        root = np.linalg.cholesky(normal)
        volume = 2.0 * float(np.sum(np.log(np.diag(root)))) + float(np.sum(np.log(size)))
        price = WALKS_ARE * sum(settings[::2]) + NAMELESS_IS * sum(settings[1::2])
        return -0.5 * (left - explained + volume) - price

    def _solved(
        self, products: Products, added: Added, settings: Settings, dropped: tuple[int, ...]
    ) -> tuple[Array, Array]:
        """Solve for the likeliest strengths, shared by the releases (columns,) and of each (releases, columns)."""
        normal, aim, size, _ = self._system(products, added, settings)
        found = _solution(normal, aim, dropped) * self._scales(added, settings) / np.sqrt(size)
        columns = self.columns(added)
        each = np.tile(found[: len(columns)], (len(self.rigs), 1))
        for i in range(len(self.rigs)):
            for j, (column, varies) in enumerate(self.own):
                own = found[len(columns) + i * len(self.own) + j]
                each[i, columns.index(column)] += varies * own
        return found[: len(columns)], each

    def _scales(self, added: Added, settings: Settings) -> Array:
        """Return the prior standard deviations of the unknowns."""
        return np.concatenate(
            [
                FLAT * self.laws.natural[list(self.base)],
                np.array(added.scales),
                np.ones(len(self.own) * len(self.rigs)),
                *(np.full(self.nameless, SIZES[settings[2 * channel + 1]]) for channel in self.channels),
            ]
        )

    def _places(self, products: Products, added: Added) -> list[int]:
        """Return the places among the products of the base and of laws beside it."""
        return [products.used.index(column) for column in self.columns(added)]

    def _system(
        self, products: Products, added: Added, settings: Settings
    ) -> tuple[Array, Array, Array, float]:
        """Return the normal matrix with a unit diagonal, the right side, the old diagonal, and the misfit without unknowns.

        Unknowns are in units of their scales, and of the root of the diagonal.
        """
        joined, determinant = products.joined(self._places(products, added), settings)
        scale = self._scales(added, settings)
        normal = joined[:-1, :-1] * np.outer(scale, scale) + np.eye(len(scale))
        aim, left = joined[:-1, -1] * scale, float(joined[-1, -1]) + determinant
        for column in added.tied:  # its strength is the spring's, give or take its scale
            law, spring = len(self.base) + added.laws.index(column), self.laws.spring_of(column)
            assert spring is not None
            ratio = scale[spring] / scale[law]
            normal[spring, spring] += ratio**2
            normal[spring, law] -= ratio
            normal[law, spring] -= ratio
        size = np.diag(normal).copy()
        root = np.sqrt(size)
        return normal / np.outer(root, root) + _RIDGE * np.eye(len(scale)), aim / root, size, left

    def _noise_at(self, places: Settings) -> tuple[float, ...]:
        """Return the noise at places in NOISE, by channel, and last the absolute one."""
        relative = tuple(float(NOISE[place]) for place in places[:-1])
        return (*relative, float(NOISE[places[-1]]) * self._smallest)

    def _fit_noise(self) -> None:
        """Find the likeliest noise where nothing is named, and the likeliest sizes with it."""
        begun = self.products(self.observed, self.base)

        def nats(places: Settings) -> float:
            self.noise = self._noise_at(places)
            products = replace(begun, noise=self.noise)
            try:
                found, self._begin = _climb(lambda s: self._nats(products, Added(), s), self._begin)
            except LinAlgError:
                return -np.inf
            return found

        middle = (len(NOISE) // 2,) * (len(self.channels) + 1)
        _, places = _climb(nats, middle, top=len(NOISE))
        nats(places)


def _climb(
    nats: Callable[[Settings], float], begin: Settings, top: int = len(SIZES)
) -> tuple[float, Settings]:
    """Find the largest value of a function of places, and where, moving one place at a time."""
    known: dict[Settings, float] = {}

    def at(places: Settings) -> float:
        if places not in known:
            known[places] = nats(places)
        return known[places]

    best = begin
    for _ in range(_ROUNDS):
        before = best
        for k, way in product(range(len(begin)), (-1, 1, None)):
            while True:
                place = 0 if way is None else best[k] + way
                other = (*best[:k], place, *best[k + 1 :])
                if not 0 <= place < top or at(other) <= at(best):
                    break
                best = other
        if best == before:
            break
    return at(best), best


def _solution(normal: Array, aims: Array, dropped: tuple[int, ...]) -> Array:
    """Return the likeliest unknowns of a system for one aim (n,) or several (n, m), those that are `dropped` being zero."""
    kept = np.delete(np.arange(len(aims)), list(dropped))
    found = np.zeros(aims.shape)
    found[kept] = np.linalg.solve(normal[kept[:, None], kept], aims[kept])
    return found
