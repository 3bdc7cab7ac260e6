"""Flags on single readings: what one channel shows that no smooth motion does.

The readings around one that is doubtful say where it should lie: a cubic through the two nearest fresh readings on either
side. A reading that repeats the one before, or lies on a flat top, is flagged where that cubic passes it by more than
rounding, noise and the cubic's own error for a motion of this period can explain. Only readings in mid-oscillation are
flagged: a mass at rest, held or stopped, repeats its readings rightly.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from daq.recording import Array, Mask, runs

SHARE = 0.2
"""Share of the usual swing below which a motion is not looked at."""
FAINT = 0.35
"""The same for a motion that is compared from cycle to cycle, as a share of that share."""
STEADY = 0.3
"""Share of the swing on the one side of a reading that there must be on the other."""
NOISES = 8.0
OWN_ERRORS = 3.0
"""Noises, and errors of the cubic for a sine of this period, by which a reading may miss it."""
QUANTA = 20.0
"""Quanta and noises that the swing around a long hold has at least: a sine that dwells for a quarter of its period has 6."""
FLAT_SHARE = 0.05
SHORTEST_FLAT = 3
"""Share of the half swing that a flat top cuts off at least, and how many readings it has."""
JUMP = 0.7
"""Share of the whole swing that a converter jumps when it wraps round."""
PASSED_BY = 0.15
"""Share of that jump by which the readings around it may fail to join once it is taken out."""
SPIKE = 14.0
SPIKE_SHARE = 0.08
WIDEST_SPIKE = 3
LIKELY, MORE_OFTEN, FEWEST, LEAST_SHARE = 0.3, 3.0, 10, 0.02
"""Readings repeat too often where that has less than these odds, if so many times more than expected, and so many at least."""
AGAIN, AS_ROUGH, COARSE = 0.06, 0.3, 24.0
"""Within which share of a period, and how rough, a motion's own kink comes again; in what period (readings) this is seen."""
UNEVEN = 5.0
"""A spike is so many noises and shares of the swing high, and so many times what its neighbours stray from one cubic."""


class Flag(StrEnum):
    """What is wrong with a reading; `LATE` is for readings that were not taken at their time."""

    SATURATED = "saturated"
    STUCK = "stuck"
    REPEATED = "repeated"
    WRAPPED = "wrapped"
    SPIKE = "spike"
    GAIN = "gain changed"
    SIGN = "sign changed"
    LATE = "late"


@dataclass(frozen=True, eq=False)
class Flagged:
    """The flags of one channel, masks of shape (n,), and its readings with what is flagged or lost filled in."""

    masks: Mapping[Flag, Mask]
    filled: Array
    moving: Mask


@dataclass(frozen=True, eq=False)
class _Swing:
    """Peak to peak over one period before and after each reading, (n,); `steady` where it oscillates on both sides."""

    before: Array
    after: Array
    enough: float

    @property
    def half(self) -> Array:
        return 0.5 * np.maximum(self.before, self.after)

    def steady(self, first: NDArray[np.int64], last: NDArray[np.int64], share: float = 1.0) -> Mask:
        before, after = self.before[first], self.after[last]
        larger = np.maximum(before, after)
        return np.asarray((np.minimum(before, after) > STEADY * larger) & (larger > share * self.enough))


def flag_readings(
    samples: Array, valid: Mask, period: float, moves_until: int = 0, released: int | None = None
) -> Flagged:
    """Return the flags of one channel, shape (n,), that oscillates with about this `period` (samples).

    `moves_until` is the reading until which other channels show that the mass oscillates, `released` the first one of a
    free motion, where it is known.
    """
    x = _filled(samples, valid)
    swing = _swing(x, period, released)
    x, wrapped = _unwrapped(x, valid, swing, period)
    if wrapped.any():
        swing = _swing(x, period, released)
    fresh = valid.copy()
    fresh[1:] &= x[1:] != x[:-1]
    noise = np.hypot(_noise(_filled(x, fresh), swing, period), 0.5 * _usual_gap(x))
    everywhere = np.arange(len(x))
    steady = swing.steady(everywhere, everywhere)
    missed = _misses(x, fresh, steady, swing.half, period, noise)
    spikes = _spikes(_filled(x, valid & ~missed), valid, swing, period, noise) & ~missed
    flat = _flat_tops(x, fresh & ~spikes, missed, swing, period, noise)
    missed &= ~_recurring(x, missed, period)
    missed |= _too_often(x, fresh, valid, swing, noise)
    held = (_long_holds(x, valid, swing, period, noise, moves_until) | missed) & ~spikes
    masks = {Flag.WRAPPED: wrapped, Flag.SPIKE: spikes} | _named(x, held, flat, period)
    return Flagged(masks, _filled(x, valid & ~held & ~flat & ~spikes), swing.steady(everywhere, everywhere, FAINT))


def _swing(x: Array, period: float, released: int | None = None) -> _Swing:
    """Measure the swing in blocks of an eighth of a period, so that few readings far off do not count."""
    block = max(int(period / 8.0), 1)
    count = -(-len(x) // block)
    reach = max(round(period / block), 2)
    if count <= 2 * reach:
        zero = np.zeros(len(x))
        return _Swing(zero, zero, np.inf)
    padded = np.concatenate([x, np.full(count * block - len(x), x[-1])]).reshape(count, block)
    thin = padded[:, :: -(-block // 8)]
    windows = np.lib.stride_tricks.sliding_window_view(thin, reach, axis=0)
    size = np.empty(len(windows))
    for first in range(0, len(windows), 4096):
        part = windows[first : first + 4096].reshape(-1, reach * thin.shape[1])
        low, high = np.quantile(part, (0.1, 0.9), axis=1)
        size[first : first + 4096] = (high - low) / np.cos(0.1 * np.pi)
    earlier, later, lasting = np.zeros(count), np.zeros(count), np.zeros(count)
    earlier[reach:] = size[: count - reach]
    later[: count - reach] = size[1:]
    back = max(3 * reach // 4, 1)  # a motion has lasted for longer than the pull that began it
    lasting[back:] = np.minimum(earlier[back:], earlier[:-back])
    of = np.arange(len(x)) // block
    before, after = lasting[of], later[of]
    if released is not None:
        begin = slice(released, released + round(2.0 * period))
        before[begin] = np.maximum(before[begin], after[begin])
    return _Swing(before, after, SHARE * float(size.max()))


def _weights(nodes: Array, at: Array) -> Array:
    """Return the weights of four `nodes` (m, 4) in the cubic through them at the places `at`, (m,): shape (m, 4)."""
    out = np.ones(nodes.shape)
    for i in range(4):
        for j in range(4):
            if i != j:
                out[:, i] *= (at - nodes[:, j]) / (nodes[:, i] - nodes[:, j])
    return out


def _nodes(keep: Mask, at: NDArray[np.int64]) -> tuple[NDArray[np.int64], Mask]:
    """Return the two kept readings on either side of each place, (m, 4), and where there are such, (m,)."""
    known = np.flatnonzero(keep)
    place = np.searchsorted(known, at)
    there = (place >= 2) & (place <= len(known) - 2)
    if len(known) < 4:
        return np.zeros((len(at), 4), dtype=np.int64), np.zeros(len(at), dtype=np.bool_)
    first = np.clip(place - 2, 0, len(known) - 4)
    return known[first[:, None] + np.arange(4)], there


def _filled(x: Array, keep: Mask) -> Array:
    """Return the readings with those that are not kept on the cubic through their neighbours, or the straight line at the ends."""
    out = np.array(x)
    at = np.flatnonzero(~keep)
    if not len(at) or keep.sum() < 4:
        return np.nan_to_num(out)
    nodes, there = _nodes(keep, at)
    known = np.flatnonzero(keep)
    out[at] = np.interp(at, known, x[known])
    if there.any():
        out[at[there]] = (_weights(nodes[there].astype(float), at[there].astype(float)) * x[nodes[there]]).sum(axis=1)
    return out


def _noise(x: Array, swing: _Swing, period: float) -> Array:
    """Return the standard deviation of what is not smooth near each reading, (n,).

    By the fourth difference, over a period and wherever the channel moves, whichever is more.
    """
    rough = np.abs(np.diff(x, 4))
    moves = swing.half[2:-2] * 2.0 > swing.enough
    if not moves.any():
        return np.zeros(len(x))
    width = max(round(period), 16)
    count = max(len(rough) // width, 1)
    blocks = rough[: count * width].reshape(count, -1) if len(rough) >= width else rough[None]
    near = np.median(blocks, axis=1)[np.minimum(np.arange(len(x)) // width, count - 1)]
    return np.asarray(np.maximum(near, np.median(rough[moves])) / 0.6745 / np.sqrt(70.0))


def _usual_gap(x: Array) -> float:
    gaps = np.diff(np.unique(x))
    return float(np.median(gaps)) if len(gaps) else 0.0


def _quantum(x: Array, at: NDArray[np.int64]) -> Array:
    """Return the gap between each reading and the next other values of the record, (m,): its rounding at most."""
    known = np.unique(x)
    if len(known) < 3:
        return np.full(len(at), np.inf)
    gaps = np.diff(known)
    place = np.searchsorted(known, x[at])
    below = gaps[np.clip(place - 1, 0, len(gaps) - 1)]
    above = gaps[np.clip(place, 0, len(gaps) - 1)]
    return np.asarray(np.maximum(np.where(place > 0, below, above), np.where(place < len(gaps), above, below)))


def _allowed(
    x: Array, nodes: NDArray[np.int64], weights: Array, at: NDArray[np.int64], half: Array, period: float, noise: Array
) -> Array:
    """Return by how much the cubic may pass each reading: rounding, noise, and its own error on a sine of this period."""
    turn = np.exp(2j * np.pi * (nodes - at[:, None]) / period)
    own = np.abs((weights * turn).sum(axis=1) - 1.0)
    rounding = 0.75 * _quantum(x, at) * (1.0 + np.abs(weights).sum(axis=1))
    spread = noise[at] * np.sqrt(1.0 + (weights**2).sum(axis=1))
    return np.asarray(np.maximum(np.maximum(rounding, NOISES * spread), OWN_ERRORS * half * own))


def _misses(
    x: Array, keep: Mask, moves: Mask, half: Array, period: float, noise: Array, share: float = 0.0
) -> Mask:
    """Return which readings that are not kept lie off the cubic through those that are, where the channel `moves`, (n,)."""
    off = np.zeros(len(x), dtype=np.bool_)
    at = np.flatnonzero(~keep)
    at = at[moves[at]]
    nodes, there = _nodes(keep, at)
    at, nodes = at[there], nodes[there]
    if not len(at):
        return off
    weights = _weights(nodes.astype(float), at.astype(float))
    passed = np.abs((weights * x[nodes]).sum(axis=1) - x[at])
    off[at] = passed > np.maximum(_allowed(x, nodes, weights, at, half[at], period, noise), share * half[at])
    return off


def _too_often(x: Array, fresh: Mask, valid: Mask, swing: _Swing, noise: Array) -> Mask:
    """Return the readings that repeat the one before while the channel moves on, where they are too many for chance.

    Two readings of a slope are equal by chance as often as rounding and noise make up for the slope.
    """
    everywhere = np.arange(len(x))
    smooth = _filled(x, fresh)
    slope = np.zeros(len(x))
    slope[3:-2] = np.abs(smooth[5:] - smooth[:-5]) / 5.0
    step = max(_usual_gap(x), 1e-300)
    slope = np.maximum(slope - 0.5 * noise, 0.0)
    spread = np.sqrt(2.0 * noise**2 + step**2 / 6.0)
    odds = np.maximum(step / (np.sqrt(2.0 * np.pi) * spread) * np.exp(-0.5 * (slope / spread) ** 2), 1.0 - slope / step)
    fast = swing.steady(everywhere, everywhere) & valid & (odds < LIKELY)
    repeats = fast & ~fresh
    expected = float(odds[fast].sum())
    often = repeats.sum() > MORE_OFTEN * expected + FEWEST and repeats.sum() > LEAST_SHARE * fast.sum()
    return np.asarray(repeats) if often else np.zeros(len(x), dtype=np.bool_)


def _long_holds(
    x: Array, valid: Mask, swing: _Swing, period: float, noise: Array, moves_until: int
) -> Mask:
    """Return the readings of holds of a quarter of a period and more with large swings on both sides, or while others move."""
    off = np.zeros(len(x), dtype=np.bool_)
    same = np.zeros(len(x), dtype=np.bool_)
    same[1:] = (x[1:] == x[:-1]) & valid[1:] & valid[:-1]
    for first, stop in runs(same):
        if stop - first < period / 4.0:
            continue
        begin = np.array([first - 1])
        large = QUANTA * max(float(_quantum(x, begin)[0]), float(noise[first]))
        end = np.array([min(stop, len(x) - 1)])
        stops = bool(swing.steady(begin, end)[0]) and min(swing.before[first - 1], swing.after[end[0]]) > large
        moved = swing.before[first - 1] > max(large, swing.enough)
        if stops or (moved and moves_until > min(stop, first + period)):
            off[first:stop] = True
    return off


def _flat_tops(x: Array, fresh: Mask, held: Mask, swing: _Swing, period: float, noise: Array) -> Mask:
    """Return the readings at the highest and the lowest level that the cubic from outside that level leaves behind."""
    flat = np.zeros(len(x), dtype=np.bool_)
    moves = 2.0 * swing.half > swing.enough
    if not moves.any():
        return flat
    for sign in (1.0, -1.0):
        level = sign * x
        edge = float(level[moves & (fresh | held)].max())
        near = np.asarray(level >= edge - NOISES * noise)
        off = _misses(
            np.where(near, sign * edge, x), ~near & fresh, moves, swing.half, period, noise, FLAT_SHARE
        )
        tops = [(first, stop) for first, stop in runs(off & near) if stop - first >= SHORTEST_FLAT]
        for first, stop in tops if len(tops) > 1 else ():
            flat[first:stop] = True
        flat |= near & held & (len(tops) > 1)
    return flat


def _named(x: Array, held: Mask, flat: Mask, period: float) -> dict[Flag, Mask]:
    """Tell flat tops, long holds and single repeated readings apart."""
    stuck, repeated = np.zeros_like(held), np.zeros_like(held)
    saturated = flat.copy()
    for first, stop in runs(held & ~flat):
        kind = stuck if stop - first >= max(period / 8.0, 3.0) else repeated
        kind[first:stop] = True
    return {Flag.SATURATED: saturated, Flag.STUCK: stuck, Flag.REPEATED: repeated}


def _unwrapped(x: Array, valid: Mask, swing: _Swing, period: float) -> tuple[Array, Mask]:
    """Return the readings without the jumps of a converter that wraps round, and which readings lay beyond them."""
    nothing = np.zeros(len(x), dtype=np.bool_)
    step = np.diff(x)
    at = np.flatnonzero((np.abs(step) > JUMP * np.ptp(x)) & valid[1:] & valid[:-1]) + 1
    at = at[(at >= 3) & (at < len(x) - 3)]
    if period < 8.0 or len(at) < 2 or not swing.steady(at - 1, at).any():
        return x, nothing
    size = float(np.median(np.abs(step[at - 1])))
    onward = 0.5 * ((x[at - 1] - x[at - 2]) + (x[at + 1] - x[at]))
    joined = np.abs(step[at - 1] - np.sign(step[at - 1]) * size - onward) < PASSED_BY * size
    turns = np.zeros(len(x))
    turns[at[joined]] = -np.sign(step[at[joined] - 1])
    total = np.cumsum(turns)
    wrapped = np.asarray(total != np.median(total))
    longest = max((stop - first for first, stop in runs(wrapped)), default=0)
    if joined.sum() < 2 or longest < 2 or np.abs(total - np.median(total)).max() > 1.0:
        return x, nothing
    return x + size * (total - np.median(total)), wrapped


def _spikes(x: Array, valid: Mask, swing: _Swing, period: float, noise: Array) -> Mask:
    """Return readings, up to three in a row, far off the cubic through three readings on either side that agree among themselves.

    What comes again a period or half a period later is the motion's own, as a blow against a stop is.
    """
    out = np.zeros(len(x), dtype=np.bool_)
    for width in range(1, WIDEST_SPIKE + 1):
        place = np.arange(width + 6.0) - 0.5 * (width + 5)
        inside = slice(3, 3 + width)
        outside = np.r_[0:3, 3 + width : 6 + width]
        if len(x) < width + 6:
            break
        powers = place[:, None] ** np.arange(4)
        fit = powers @ np.linalg.pinv(powers[outside])
        view = np.lib.stride_tricks.sliding_window_view(x, width + 6)
        off = view - view[:, outside] @ fit.T
        high, around = np.abs(off[:, inside]).min(axis=1), np.abs(off[:, outside]).max(axis=1)
        turn = np.exp(2j * np.pi * place / period)
        own = float(np.abs(turn - fit @ turn[outside])[inside].max())
        begin = np.arange(len(high)) + 3
        half = swing.half[begin]
        spread = noise[begin] * np.sqrt(1.0 + (fit[inside] ** 2).sum(axis=1).max())
        limit = np.maximum(np.maximum(SPIKE * spread, UNEVEN * around), np.maximum(SPIKE_SHARE, OWN_ERRORS * own) * half)
        whole = np.lib.stride_tricks.sliding_window_view(valid & ~out, width + 6).all(axis=1)
        found = begin[(high > limit) & whole & swing.steady(np.maximum(begin - 3, 0), np.minimum(begin + width + 2, len(x) - 1))]
        for shift in range(width):
            out[found + shift] = True
    return out & ~_recurring(x, out, period)


def _recurring(x: Array, marked: Mask, period: float) -> Mask:
    """Return the marks where the channel is as rough again half a period and a period away, but not in between."""
    out = np.zeros(len(x), dtype=np.bool_)
    at = np.flatnonzero(marked)
    if not len(at):
        return out
    reach = max(round(AGAIN * period), 1)
    rough = np.zeros(len(x))
    rough[2:-2] = np.abs(np.diff(x, 4))
    near = np.lib.stride_tricks.sliding_window_view(np.pad(rough, reach), 2 * reach + 1).max(axis=1)
    own = AS_ROUGH * near[at]

    def rougher(aways: tuple[float, ...]) -> Mask:
        places = [at + round(side * away * period) for away in aways for side in (-1, 1)]
        return np.asarray(np.max([near[np.clip(p, 0, len(x) - 1)] for p in places], axis=0) > own)

    between = rougher((0.25,)) if period > COARSE else np.zeros(len(at), dtype=np.bool_)
    out[at] = rougher((0.5, 1.0)) & ~between
    return out


def last_moving(samples: Array, period: float) -> int:
    """Return the last reading of a channel, shape (n,), about which it oscillates."""
    swing = _swing(samples, period)
    everywhere = np.arange(len(samples))
    return int(np.flatnonzero(swing.steady(everywhere, everywhere)).max(initial=0))
