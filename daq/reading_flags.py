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

from daq.recording import Array, Mask, runs
from daq.smooth_course import (
    FAINT,
    Swing,
    filled,
    nodes_of,
    noise_of,
    quantum_at,
    swing_of,
    usual_gap,
    weights_of,
)

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
SPIKE, SPIKE_SHARE, UNEVEN = 20.0, 0.2, 5.0
"""A spike is so many noises, such a share of the half swing, and so many times its neighbours' stray from a cubic high."""
WIDEST_SPIKE = 3
LIKELY, MORE_OFTEN, FEWEST, LEAST_SHARE = 0.3, 3.0, 10, 0.02
"""Readings of such odds repeat too often if they do so many times more than expected, and so many, such a share of them."""
AGAIN, AS_ROUGH, COARSE = 0.06, 0.3, 24.0
"""Within this share of a period, and so rough, a kink comes again, and none is in between, seen from this period on."""


class Flag(StrEnum):
    """What is wrong with a reading."""

    SATURATED = "saturated"
    STUCK = "stuck"
    REPEATED = "repeated"
    WRAPPED = "wrapped"
    SPIKE = "spike"
    GAIN = "gain changed"
    SIGN = "sign changed"


@dataclass(frozen=True, eq=False)
class Flagged:
    """The flags of one channel, masks (n,), its readings with what is flagged or lost filled in, and where it oscillates."""

    masks: Mapping[Flag, Mask]
    filled: Array
    moving: Mask


@dataclass(frozen=True, eq=False)
class _Course:
    """One channel under inspection: readings, which of them exist and which are fresh, swing, noise, period."""

    x: Array
    valid: Mask
    fresh: Mask
    swing: Swing
    noise: Array
    period: float


def flag_readings(
    samples: Array, valid: Mask, period: float, moves_until: int, released: int | None
) -> Flagged:
    """Return the flags of one channel, shape (n,), that oscillates with about this `period` (samples).

    `moves_until` is the reading until which other channels show that the mass oscillates, `released` the first one of a
    free motion, where it is known.
    """
    x = filled(samples, valid)
    swing = swing_of(x, period, released)
    x, wrapped = _unwrapped(x, valid, swing, period)
    if wrapped.any():
        swing = swing_of(x, period, released)
    fresh = valid.copy()
    fresh[1:] &= x[1:] != x[:-1]
    noise = np.hypot(noise_of(filled(x, fresh), swing, period), 0.5 * usual_gap(x))
    course = _Course(x, valid, fresh, swing, noise, period)
    missed = _misses(course, x, fresh, swing.steady())
    spikes = _spikes(course, filled(x, valid & ~missed)) & ~missed
    held = _long_holds(course, moves_until) | _too_often(course)
    flat = _flat_tops(course, fresh & ~spikes, missed | held)
    held = (held | missed & ~_recurring(x, missed, period)) & ~spikes & ~flat
    masks = {Flag.WRAPPED: wrapped, Flag.SPIKE: spikes, Flag.SATURATED: flat} | _holds(held, period)
    return Flagged(masks, filled(x, valid & ~held & ~flat & ~spikes), swing.steady(share=FAINT))


def _misses(course: _Course, x: Array, keep: Mask, moves: Mask, share: float = 0.0) -> Mask:
    """Return which readings that are not kept the cubic through those that are passes by, where the channel `moves`, (n,).

    It may do so by rounding, noise and its own error on a sine of this period, and by this share of the half swing.
    """
    off = np.zeros(len(x), dtype=np.bool_)
    at, nodes = nodes_of(keep, np.flatnonzero(~keep & moves))
    if not len(at):
        return off
    weights = weights_of(nodes, at)
    half = course.swing.half[at]
    turn = np.exp(2j * np.pi * (nodes - at[:, None]) / course.period)
    own = OWN_ERRORS * half * np.abs((weights * turn).sum(axis=1) - 1.0)
    rounding = 0.75 * quantum_at(x, at) * (1.0 + np.abs(weights).sum(axis=1))
    noise = NOISES * course.noise[at] * np.sqrt(1.0 + (weights**2).sum(axis=1))
    passed = np.abs((weights * x[nodes]).sum(axis=1) - x[at])
    off[at] = passed > np.max([own, rounding, noise, share * half], axis=0)
    return off


def _too_often(course: _Course) -> Mask:
    """Return the readings that repeat the one before while the channel moves on, where they are too many for chance.

    Two readings of a slope are equal by chance as often as rounding and noise make up for the slope.
    """
    smooth = filled(course.x, course.fresh)
    slope = np.zeros(len(smooth))
    slope[3:-2] = np.abs(smooth[5:] - smooth[:-5]) / 5.0
    slope = np.maximum(slope - 0.5 * course.noise, 0.0)
    step = max(usual_gap(course.x), 1e-300)
    spread = np.sqrt(2.0 * course.noise**2 + step**2 / 6.0)
    by_noise = step / (np.sqrt(2.0 * np.pi) * spread) * np.exp(-0.5 * (slope / spread) ** 2)
    odds = np.maximum(by_noise, 1.0 - slope / step)
    fast = course.swing.steady() & course.valid & (odds < LIKELY)
    repeats = fast & ~course.fresh
    count = repeats.sum()
    often = count > MORE_OFTEN * float(odds[fast].sum()) + FEWEST and count > LEAST_SHARE * fast.sum()
    return np.asarray(repeats) if often else np.zeros_like(repeats)


def _long_holds(course: _Course, moves_until: int) -> Mask:
    """Return the readings of holds of a quarter period and more between large swings, or while another channel moves."""
    x, swing = course.x, course.swing
    off, same = np.zeros(len(x), dtype=np.bool_), np.zeros(len(x), dtype=np.bool_)
    same[1:] = (x[1:] == x[:-1]) & course.valid[1:] & course.valid[:-1]
    for first, stop in runs(same):
        if stop - first < course.period / 4.0:
            continue
        begin, end = np.array([first - 1]), np.array([min(stop, len(x) - 1)])
        large = QUANTA * max(float(quantum_at(x, begin)[0]), float(course.noise[first]))
        before, after = float(swing.before[first - 1]), float(swing.after[end[0]])
        goes_on = bool(swing.steady(begin, end)[0]) and after > large
        others_do = before > swing.enough and moves_until > min(stop, first + course.period)
        off[first:stop] = before > large and (goes_on or others_do)
    return off


def _flat_tops(course: _Course, fresh: Mask, held: Mask) -> Mask:
    """Return the readings at the highest and the lowest level where the cubic from outside that level passes it by twice."""
    x = course.x
    flat = np.zeros(len(x), dtype=np.bool_)
    moves = 2.0 * course.swing.half > course.swing.enough
    for sign in (1.0, -1.0):
        edge = float((sign * x)[moves & (fresh | held)].max(initial=-np.inf))
        near = np.asarray(sign * x >= edge - NOISES * course.noise)
        off = _misses(course, np.where(near, sign * edge, x), ~near & fresh, moves, FLAT_SHARE)
        tops = [(first, stop) for first, stop in runs(off & near) if stop - first >= SHORTEST_FLAT]
        if len(tops) > 1:
            flat |= near & held
            for first, stop in tops:
                flat[first:stop] = True
    return flat


def _holds(held: Mask, period: float) -> dict[Flag, Mask]:
    """Tell long holds and single repeated readings apart."""
    stuck = np.zeros_like(held)
    for first, stop in runs(held):
        stuck[first:stop] = stop - first >= max(period / 8.0, SHORTEST_FLAT)
    return {Flag.STUCK: stuck, Flag.REPEATED: held & ~stuck}


def _unwrapped(x: Array, valid: Mask, swing: Swing, period: float) -> tuple[Array, Mask]:
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
    if joined.sum() < 2 or longest < 2:
        return x, nothing
    return x + size * (total - np.median(total)), wrapped


def _spikes(course: _Course, x: Array) -> Mask:
    """Return readings, up to three in a row, far off the cubic through three on either side that agree among themselves.

    What comes again a period or half a period later is the motion's own, as a blow against a stop is.
    """
    out = np.zeros(len(x), dtype=np.bool_)
    view = np.lib.stride_tricks.sliding_window_view
    for width in range(1, WIDEST_SPIKE + 1):
        place = np.arange(width + 6.0) - 0.5 * (width + 5)
        inside, outside = np.arange(3, 3 + width), np.r_[0:3, 3 + width : 6 + width]
        powers = place[:, None] ** np.arange(4)
        fit = powers @ np.linalg.pinv(powers[outside])
        windows = view(x, width + 6)
        off = np.abs(windows - windows[:, outside] @ fit.T)
        high, around = off[:, inside].min(axis=1), off[:, outside].max(axis=1)
        turn = np.exp(2j * np.pi * place / course.period)
        own = OWN_ERRORS * float(np.abs(turn - fit @ turn[outside])[inside].max())
        begin = np.arange(len(high)) + 3
        noise = SPIKE * course.noise[begin] * np.sqrt(1.0 + (fit[inside] ** 2).sum(axis=1).max())
        limit = np.max([noise, UNEVEN * around, max(SPIKE_SHARE, own) * course.swing.half[begin]], axis=0)
        whole = view(course.valid & ~out, width + 6).all(axis=1)
        found = begin[(high > limit) & whole & course.swing.steady(begin - 3, begin + width + 2)]
        out[(found[:, None] + np.arange(width)).ravel()] = True
    return out & ~_recurring(x, out, course.period)


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
