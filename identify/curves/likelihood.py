"""The marginal likelihood of a decay's curves: how probable laws make them, whatever else the rig does.

Cycle by cycle a curve gives the logarithm of the amplitude and the phase. Along the measured amplitudes both are linear in
the strength of every law (Krylov and Bogoliubov 1937), so that all that is not known is a column with a normal prior, or a
part of the noise, and integrates to a closed form (a linear mixed model; Rasmussen and Williams 2006, eq. 2.43):

    log amplitude, phase = start + base and laws + a law without a name + random walks of damper and spring + noise

and so is the centre of the oscillation, which a one-sided force moves, where the reading is a displacement.

The walks and the law without a name stand in every hypothesis. So a name has to beat nothing, a drifting rig, and a law
that nobody knows, at once. Sizes of walks and of the law without a name are chosen anew for each hypothesis, at a price.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from scipy.linalg import LinAlgError, cholesky, solve_triangular

from identify.arrays import Array
from identify.curves.averaged_law import values_of
from identify.curves.curve_regression import CurveRegression, Rows
from identify.curves.curve_search import CurveSearch
from identify.curves.decay_curve import DecayCurve
from identify.curves.isolated_mode import IsolatedMode, simulated_curve
from identify.effects.force_effect import ForceEffect, LinearPart
from identify.model.model import Model
from identify.priors import (
    BENDS_OVER,
    FLAT,
    LEAKS,
    NAMELESS_IS,
    NOISE,
    SAME,
    SIZES,
    STRENGTHS,
    WALKS_ARE,
)

_CENTRE = 2
"""Channel of the centre; 0 is the logarithm of the amplitude, 1 the phase."""

_OVERLAPS = 5
"""Windows on either side that may share readings with one."""

_ALONE = 0.02
"""Share of a window's error that no other window shares, so that the noise can be inverted."""

_ROUNDS = 6
_RIDGE = 1e-12
"""Added to a correlation matrix, so that it has a root."""

_BENDS = 3
"""Order of the polynomial in the logarithm of the amplitude that smooths a measured loss."""

Settings = tuple[int, ...]
"""Places in SIZES, by channel: of its walk and of its law without a name."""


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
class Hypothesis:
    """Laws that are tried, with the log marginal likelihood (nats) and the strengths that are likeliest.

    `strengths` (releases, columns of base and laws) are those of each release. `possible` is False where one is out of
    bounds.
    """

    added: Added
    nats: float
    settings: Settings
    strengths: Array
    possible: bool = True


@dataclass(frozen=True, eq=False)
class _Release:
    """One release: its curve, what laws (n, laws) and those without a name (n, m) make of each channel, and its noise.

    The centre is in units of the largest amplitude. `overlap` (n, n) correlates the errors of windows, `walks` are the
    covariances (n, n) that random walks give the channels.
    """

    curve: DecayCurve
    columns: tuple[Array, ...]
    nameless: tuple[Array, ...]
    overlap: Array
    walks: tuple[Array, ...]

    def noise(self, channel: int, noise: Sequence[float], walk: float) -> Array:
        """Return the covariance of what noise and a walk make of a channel, (n, n); `noise` as CurveLikelihood has it."""
        size = self.curve.amplitude
        unit = size if channel != _CENTRE else np.full(len(size), size.max())
        absolute, misfit = noise[-1] / unit, LEAKS[channel] * self.curve.misfit * size / unit
        own = noise[channel] ** 2 + np.outer(absolute, absolute) + np.outer(misfit, misfit)
        return np.asarray(self.overlap * own + walk**2 * self.walks[channel])


@dataclass(frozen=True, eq=False)
class _Products:
    """Products of the whitened columns `used`, nameless laws, own springs and dampers, and observations."""

    of: "CurveLikelihood"
    observed: tuple[Array, ...]
    used: tuple[int, ...]
    noise: tuple[float, ...]
    made: dict[tuple[int, int], tuple[Array, float]] = field(default_factory=dict)

    def __call__(self, channel: int, walk: int) -> tuple[Array, float]:
        """Return the products and the logarithm of the noise's determinant, for one size of the walk."""
        if (channel, walk) not in self.made:
            self.made[channel, walk] = self._make(channel, float(SIZES[walk]))
        return self.made[channel, walk]

    def _make(self, channel: int, walk: float) -> tuple[Array, float]:
        of, laws, m = self.of, len(self.used), self.of.nameless
        total = laws + m + len(of.own) * len(of.releases) + 1
        products, determinant = np.zeros((total, total)), 0.0
        for i, release in enumerate(of.releases):
            columns = release.columns[channel]
            design = np.zeros((len(columns), total + 1))
            design[:, 0] = 1.0
            design[:, 1 : 1 + laws] = columns[:, list(self.used)]
            design[:, 1 + laws : 1 + laws + m] = release.nameless[channel]
            for j, (column, varies) in enumerate(of.own):
                design[:, 1 + laws + m + i * len(of.own) + j] = columns[:, column] * varies
            design[:, -1] = self.observed[i][channel]
            factor = cholesky(release.noise(channel, self.noise, walk), lower=True)
            white = solve_triangular(factor, design, lower=True, check_finite=False)
            start = white[:, :1]  # the start is free
            power = float(np.sum(start**2))
            rest = white[:, 1:] - start * (start.T @ white[:, 1:]) / power
            products += rest.T @ rest
            determinant += 2.0 * float(np.sum(np.log(np.diag(factor)))) + float(np.log(power))
        return products, determinant


class CurveLikelihood:
    """The likelihood of the curves of a search, under its base and under laws beside it.

    `noise` is relative to the amplitude for each channel (to the largest for the centre), and last absolute.
    """

    def __init__(self, search: CurveSearch) -> None:
        self.search = search
        laws = search.regression.laws
        shares = search.regression.shares
        self.regression = CurveRegression(search.whole, laws, search.regression.frequency, shares)
        self.base = tuple(range(len(search.base)))
        self.own = tuple(self._own()) if len(search.whole) > 1 else ()
        grid, shapes = _nameless_shapes(search.whole)
        self.nameless = shapes.shape[1]
        self.channels = tuple(range(_CENTRE + all(curve.has_centre for curve in search.whole)))
        self.releases = tuple(self._release(i, mode, grid, shapes) for i, mode in enumerate(search.modes))
        usual = self.regression.solve(
            self.base, range(len(search.whole)), self.regression.measured, one_record=search.one_record
        )
        strengths = np.array([usual.of(i) for i in range(len(search.whole))])
        self.observed = self.observed_by(self.base, strengths)
        self.noise, self._begin = self._fit_noise()

    def _own(self) -> Iterator[tuple[int, float]]:
        """Yield the linear columns that each release may have a little different, and by how much."""
        for column in self.base:
            part = self.regression.laws[column].term.force.linear_part
            if part == LinearPart.STIFFNESS:
                yield column, self.regression.shares[0] * self.regression.frequency**2
            if part == LinearPart.DAMPING:
                yield column, self.regression.shares[1] * self.regression.typical_loss

    def _release(self, number: int, mode: IsolatedMode, grid: Array, shapes: Array) -> _Release:
        curve = self.regression.curves[number]
        loss, stiffness, centre = self.regression.designs[number]
        frequency, time = self.regression.frequency, curve.time - curve.time[0]
        between, at = (
            np.column_stack([np.interp(np.log(size), grid, shape) for shape in shapes.T])
            for size in (curve.between, curve.amplitude)
        )
        unnamed = 0.5 * frequency * _summed(between, curve)
        relative = curve.amplitude / curve.amplitude.max()
        early = np.minimum(time[:, None], time)
        late = np.maximum(time[:, None], time)
        walk = 0.25 * frequency**3 * early**2 * (3.0 * late - early) / 6.0  # an integrated Wiener process
        return _Release(
            curve,
            (-0.5 * _summed(loss, curve), 0.5 * _summed(stiffness, curve), centre / curve.amplitude.max()),
            (unnamed, unnamed, at * relative[:, None]),
            _overlap(mode),
            (walk, walk, frequency * early),
        )

    @cached_property
    def natural(self) -> Array:
        """Strength at which each law has the effect of the whole spring on loss or frequency, or moves the centre by an
        amplitude, (laws,); 0: at none."""
        loss, stiffness, centre = (
            np.concatenate([d[kind] for d in self.regression.designs]) for kind in range(3)
        )
        amplitude = np.concatenate([curve.amplitude for curve in self.regression.curves])
        centre = centre * self.regression.frequency / np.sqrt(np.mean(amplitude**2))
        size = np.sqrt(np.max([np.mean(effect**2, axis=0) for effect in (loss, stiffness, centre)], axis=0))
        return np.where(size > 0.0, self.regression.frequency / np.maximum(size, 1e-200), 0.0)

    def observed_by(self, columns: tuple[int, ...], strengths: Array) -> tuple[Array, ...]:
        """Return log amplitude, phase and centre of each release (3, n), less what windows and averaging do to a motion.

        `strengths` (releases, columns). What the loss does to the frequency (half of it, squared: a damped oscillator is
        slower) is taken from the measured loss where it is not that of these laws.
        """
        laws = [self.regression.laws[c] for c in columns]
        model, observed = Model(tuple(law.term for law in laws)), []
        for i, (decay, mode) in enumerate(zip(self.search.decays, self.search.modes, strict=True)):
            curve, rows = self.regression.curves[i], self.regression.measured[i]
            values = self.search.known | values_of(laws, strengths[i])
            run = simulated_curve(decay, mode, model, values, curve)
            excess = None if run is None else self.regression.excess(run, columns, strengths[i])
            rows = rows if excess is None else rows.minus(excess)
            slower = (
                _smooth_loss(rows, curve) ** 2
                - (self.regression.designs[i][0][:, columns] @ strengths[i]) ** 2
            )
            stiffness = rows.stiffness + slower / (4.0 * self.regression.frequency)
            centre = rows.centre / curve.amplitude.max()
            observed.append(
                np.array([-0.5 * _summed(rows.loss, curve), 0.5 * _summed(stiffness, curve), centre])
            )
        return tuple(observed)

    def products(self, observed: tuple[Array, ...], columns: Iterable[int]) -> _Products:
        """Return what hypotheses about some columns are made of."""
        return _Products(self, observed, tuple(sorted({*self.base, *columns})), self.noise)

    def usual(self) -> Hypothesis:
        """Return the base alone."""
        return self._likeliest(self.products(self.observed, self.base), Added(), self._begin)

    def columns(self, added: Added) -> tuple[int, ...]:
        """Return the columns of the base and of laws beside it."""
        return (*self.base, *added.laws)

    def with_law(self, products: _Products, before: Hypothesis, column: int) -> Hypothesis:
        """Return a hypothesis with one law more, with the scale of its strength that is likeliest.

        Gravity may be the whole spring, and has no constant of its own then.
        """
        natural = float(self.natural[column])
        tried = [before.added.and_law(column, float(size) * natural) for size in STRENGTHS]
        begins = {_without_walks(before.settings, still) for still in ((), (0,), (1,), (0, 1))}
        best: Hypothesis | None = None
        for _ in range(2):  # a law that explains a walk gains nothing beside it
            likeliest, begin = max(
                product(tried, sorted(begins)), key=lambda one: self._nats(products, one[0], one[1])
            )
            found = self._likeliest(products, likeliest, begin)
            if best is not None and found.nats <= best.nats:
                break
            best, begins = found, {found.settings}
        assert best is not None
        if self._spring_of(column) is None:
            return best
        tied = before.added.and_law(column, SAME * self.regression.frequency**2, tied=True)
        return max(best, self._likeliest(products, tied, best.settings), key=lambda one: one.nats)

    def _spring_of(self, column: int) -> int | None:
        """Return the place in the base of the linear law that another may be all of, None where there is none."""
        effect = self.regression.laws[column].term.effect
        part = effect.may_be_all_of if isinstance(effect, ForceEffect) else None
        parts = [self.regression.laws[c].term.force.linear_part for c in self.base]
        return parts.index(part) if part is not None and part in parts else None

    def with_own_corrections(self, before: Hypothesis, found: Hypothesis) -> Hypothesis:
        """Return a hypothesis judged on what windows and averaging make of its own motion."""
        observed = self.observed_by(self.columns(found.added), found.strengths)
        if not all(np.isfinite(one).all() for one in observed):
            return found
        return self.with_law(self.products(observed, found.added.laws), before, found.added.laws[-1])

    def _likeliest(self, products: _Products, added: Added, begin: Settings) -> Hypothesis:
        """Return a hypothesis with the likeliest walks and law without a name; what would be negative is left out."""
        columns, dropped = list(self.columns(added)), list[int]()
        low, linear = self.regression.low[columns], self.regression.linear[columns]
        while True:
            held = tuple(dropped)

            def nats(settings: Settings, held: tuple[int, ...] = held) -> float:
                return self._nats(products, added, settings, held)

            most, settings = _climb(nats, begin)
            shared, each = self._solved(products, added, settings, held)
            wrong = [j for j in range(len(columns)) if shared[j] < low[j] - 1e-12 and j not in dropped]
            if any(j >= len(self.base) for j in wrong):
                return Hypothesis(added, -np.inf, settings, each, possible=False)
            if not wrong:
                return Hypothesis(added, most, settings, each)
            dropped.append(min(wrong, key=lambda j: bool(linear[j])))

    def _nats(
        self, products: _Products, added: Added, settings: Settings, dropped: tuple[int, ...] = ()
    ) -> float:
        """Return the log marginal likelihood; `dropped` unknowns are none, which makes them no less unknown."""
        normal, aim, size, left = self._system(products, added, settings)
        factor = cholesky(normal, lower=True)
        if dropped:
            kept = np.setdiff1d(np.arange(len(aim)), dropped)
            explained = float(aim[kept] @ np.linalg.solve(normal[np.ix_(kept, kept)], aim[kept]))
        else:
            explained = float(np.sum(solve_triangular(factor, aim, lower=True, check_finite=False) ** 2))
        volume = 2.0 * float(np.sum(np.log(np.diag(factor)))) + float(np.sum(np.log(size)))
        price = WALKS_ARE * sum(settings[::2]) + NAMELESS_IS * sum(settings[1::2])
        return -0.5 * (left - explained + volume) - price

    def _solved(
        self, products: _Products, added: Added, settings: Settings, dropped: tuple[int, ...]
    ) -> tuple[Array, Array]:
        """Return the likeliest strengths that releases share (columns,) and that each has (releases, columns)."""
        normal, aim, size, _ = self._system(products, added, settings)
        kept = np.setdiff1d(np.arange(len(aim)), dropped)
        found = np.zeros(len(aim))
        found[kept] = np.linalg.solve(normal[np.ix_(kept, kept)], aim[kept])
        found *= self._scales(added, settings) / np.sqrt(size)
        columns = self.columns(added)
        each = np.tile(found[: len(columns)], (len(self.releases), 1))
        for i in range(len(self.releases)):
            for j, (column, varies) in enumerate(self.own):
                own = found[len(columns) + i * len(self.own) + j]
                each[i, columns.index(column)] += varies * own
        return found[: len(columns)], each

    def _scales(self, added: Added, settings: Settings) -> Array:
        """Return the standard deviations that the unknowns have before anything is seen."""
        return np.concatenate(
            [
                FLAT * self.natural[list(self.base)],
                np.array(added.scales),
                np.ones(len(self.own) * len(self.releases)),
                *(np.full(self.nameless, SIZES[settings[2 * channel + 1]]) for channel in self.channels),
            ]
        )

    def _system(
        self, products: _Products, added: Added, settings: Settings
    ) -> tuple[Array, Array, Array, float]:
        """Return the normal matrix with ones on its diagonal, the aim, that diagonal, and the misfit without unknowns.

        Unknowns are in units of their scales, and of the root of the diagonal.
        """
        used, m = len(products.used), self.nameless
        place = {column: at for at, column in enumerate(products.used)}
        own = range(used + m, used + m + len(self.own) * len(self.releases))
        shared = [*(place[c] for c in self.columns(added)), *own]
        count, unnamed = len(shared), range(used, used + m)
        unknowns = count + m * len(self.channels)
        normal, aim, left = np.zeros((unknowns, unknowns)), np.zeros(unknowns), 0.0
        for channel in self.channels:
            products_of, determinant = products(channel, settings[2 * channel])
            at = [*shared, *unnamed]
            to = [*range(count), *range(count + m * channel, count + m * (channel + 1))]
            normal[np.ix_(to, to)] += products_of[np.ix_(at, at)]
            aim[to] += products_of[at, -1]
            left += float(products_of[-1, -1]) + determinant
        scale = self._scales(added, settings)
        normal, aim = normal * np.outer(scale, scale) + np.eye(unknowns), aim * scale
        for column in added.tied:  # its strength is the spring's, give or take its scale
            law, spring = len(self.base) + added.laws.index(column), self._spring_of(column)
            assert spring is not None
            ratio = scale[spring] / scale[law]
            normal[spring, spring] += ratio**2
            normal[spring, law] -= ratio
            normal[law, spring] -= ratio
        size = np.diag(normal).copy()
        root = np.sqrt(size)
        return normal / np.outer(root, root) + _RIDGE * np.eye(unknowns), aim / root, size, left

    def _fit_noise(self) -> tuple[tuple[float, ...], Settings]:
        """Return the noise that is likeliest where nothing is named, and the likeliest sizes with it."""
        smallest = min(float(curve.amplitude.min()) for curve in self.search.whole)
        begin = [(4, 0, 4, 0, 0, 0)[: 2 * len(self.channels)]]

        def noise_at(places: Settings) -> tuple[float, ...]:
            relative = tuple(float(NOISE[place]) for place in places[:-1])
            return (*relative, float(NOISE[places[-1]]) * smallest)

        def nats(places: Settings) -> float:
            products = _Products(self, self.observed, self.base, noise_at(places))
            try:
                found, begin[0] = _climb(lambda s: self._nats(products, Added(), s), begin[0])
            except LinAlgError:
                return -np.inf
            return found

        middle = (len(NOISE) // 2,) * (len(self.channels) + 1)
        _, places = _climb(nats, middle, top=len(NOISE))
        nats(places)
        return noise_at(places), begin[0]


def _climb(
    nats: Callable[[Settings], float], begin: Settings, top: int = len(SIZES)
) -> tuple[float, Settings]:
    """Return the largest of a function of places, and where, one place moved at a time."""
    known: dict[Settings, float] = {}

    def at(places: Settings) -> float:
        if places not in known:
            known[places] = nats(places)
        return known[places]

    best = begin
    for _ in range(_ROUNDS):
        before = best
        for k in range(len(begin)):
            for way in (-1, 1):
                while 0 <= best[k] + way < top and at(_with(best, k, best[k] + way)) > at(best):
                    best = _with(best, k, best[k] + way)
            if at(_with(best, k, 0)) > at(best):
                best = _with(best, k, 0)
        if best == before:
            break
    return at(best), best


def _without_walks(settings: Settings, channels: tuple[int, ...]) -> Settings:
    return tuple(
        0 if k in {2 * channel for channel in channels} else place for k, place in enumerate(settings)
    )


def _with(places: Settings, k: int, place: int) -> Settings:
    return tuple(place if i == k else old for i, old in enumerate(places))


def _summed(rates: Array, curve: DecayCurve) -> Array:
    """Return rates between the points of a curve, (n - 1, ...), integrated from its first point on, (n, ...)."""
    step = curve.step.reshape((-1,) + (1,) * (rates.ndim - 1))
    return np.concatenate([np.zeros((1, *rates.shape[1:])), np.cumsum(rates * step, axis=0)])


def _smooth_loss(rows: Rows, curve: DecayCurve) -> Array:
    """Return the measured loss as a smooth function of the amplitude, (n - 1,)."""
    size = np.log(curve.between)
    order = min(_BENDS, len(size) - 1) if np.ptp(size) > BENDS_OVER / 8.0 else 0
    size = size - size.mean()
    return np.asarray(
        np.polynomial.polynomial.polyval(size, np.polynomial.polynomial.polyfit(size, rows.loss, order))
    )


def _nameless_shapes(curves: Sequence[DecayCurve]) -> tuple[Array, Array]:
    """Return log amplitudes (k,) and random smooth functions of them (k, m): their sum with normal numbers is the law."""
    size = np.log(np.concatenate([curve.amplitude for curve in curves]))
    span = float(np.ptp(size))
    grid = np.linspace(size.min(), size.max(), 8 + int(4.0 * span / BENDS_OVER))
    covariance = np.exp(-0.5 * ((grid[:, None] - grid) / BENDS_OVER) ** 2)
    power, shapes = np.linalg.eigh(covariance)
    kept = power > 1e-3 * power[-1]
    return grid, np.asarray(shapes[:, kept] * np.sqrt(power[kept]))


def _overlap(mode: IsolatedMode) -> Array:
    """Return the correlation of the errors of all windows, which share readings with their neighbours, (n, n)."""
    waves = [operator[0] + 1j * operator[1] for operator in mode.operators]
    waves = [wave / np.sqrt(np.sum(np.abs(wave) ** 2)) for wave in waves]
    count = len(waves)
    shared = np.eye(count, dtype=complex)
    for i in range(count):
        for j in range(i + 1, min(i + 1 + _OVERLAPS, count)):
            apart = int(mode.first[j] - mode.first[i])
            common = min(len(waves[i]) - apart, len(waves[j]))
            if common <= 0:
                break
            shared[i, j] = np.sum(waves[i][apart : apart + common] * np.conj(waves[j][:common]))
            shared[j, i] = np.conj(shared[i, j])
    turned = np.exp(
        -1j * np.concatenate([[0.0], np.cumsum(np.angle(np.diag(shared, 1)))])
    )  # along the motion
    along = np.real(np.conj(turned)[:, None] * shared * turned[None, :])
    return np.asarray((1.0 - _ALONE) * along + _ALONE * np.eye(count))
