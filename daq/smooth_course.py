"""What a smooth motion does around each reading: its swing, its noise, and the cubic through its neighbours."""

from dataclasses import dataclass

import numpy as np

from daq.recording import Array, Index, Mask

EACH = slice(None)

SHARE = 0.2
"""Share of the usual swing below which a motion is not looked at."""
FAINT = 0.35
"""The same for a motion that is compared from cycle to cycle, as a share of that share."""
STEADY = 0.3
"""Share of the swing on the one side of a reading that there must be on the other."""


@dataclass(frozen=True, eq=False)
class Swing:
    """Peak to peak over one period before and after each reading, (n,); `steady` where it oscillates on both sides."""

    before: Array
    after: Array
    enough: float

    @property
    def half(self) -> Array:
        """Half the swing around each reading, the larger of both sides, (n,)."""
        return 0.5 * np.maximum(self.before, self.after)

    def steady(self, first: Index | slice = EACH, last: Index | slice = EACH, share: float = 1.0) -> Mask:
        """Check whether the motion continues from before the readings `first` to after `last`, (m,) each; of every reading
        without these.
        """
        before, after = self.before[first], self.after[last]
        larger = np.maximum(before, after)
        return np.asarray((np.minimum(before, after) > STEADY * larger) & (larger > share * self.enough))


def swing_of(x: Array, period: float, released: int | None = None) -> Swing:
    """Measure the swing in blocks of an eighth of a period, so that few readings far off do not count."""
    block = max(int(period / 8.0), 1)
    count = -(-len(x) // block)
    reach = max(round(period / block), 2)
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
    return Swing(before, after, SHARE * float(size.max()))


def spectrum(x: Array, size: int | None = None) -> Array:
    """Return the power spectrum of a record (n,), its straight line taken out, as one of `size` readings (n without)."""
    place = np.linspace(-1.0, 1.0, len(x))
    bent = x - x.mean() - place * float(place @ (x - x.mean())) / float(place @ place)
    return np.asarray(np.abs(np.fft.rfft(bent * np.hanning(len(x)), size)) ** 2)


def weights_of(nodes: Index, at: Index) -> Array:
    """Return the weights of four `nodes` (m, 4) in the cubic through them at the places `at`, (m,): shape (m, 4)."""
    out = np.ones(nodes.shape)
    for i in range(4):
        for j in range(4):
            if i != j:
                out[:, i] *= (at - nodes[:, j]) / (nodes[:, i] - nodes[:, j])
    return out


def nodes_of(keep: Mask, at: Index) -> tuple[Index, Index]:
    """Return those of the places `at` that have two kept readings on either side, (m,), and these readings, (m, 4)."""
    known = np.flatnonzero(keep)
    place = np.searchsorted(known, at)
    there = (place >= 2) & (place <= len(known) - 2)
    return at[there], known[place[there, None] + np.arange(-2, 2)]


def filled(x: Array, keep: Mask) -> Array:
    """Return the readings with those that are not kept on the cubic through their neighbours, at the ends as the last."""
    out = np.array(x)
    at = np.flatnonzero(~keep)
    known = np.flatnonzero(keep)
    if not len(at) or len(known) < 4:
        return np.nan_to_num(out)
    out[at] = np.interp(at, known, x[known])
    within, nodes = nodes_of(keep, at)
    out[within] = (weights_of(nodes, within) * x[nodes]).sum(axis=1)
    return out


def noise_of(x: Array, swing: Swing, period: float) -> Array:
    """Return the standard deviation of what is not smooth near each reading, (n,).

    By the fourth difference, over a period and wherever the channel moves, whichever is more.
    """
    rough = np.abs(np.diff(x, 4))
    moves = swing.half[2:-2] * 2.0 > swing.enough
    if not moves.any():
        return np.zeros(len(x))
    width = max(round(period), 16)
    count = max(len(rough) // width, 1)
    blocks = rough[: count * width].reshape(count, -1)
    near = np.median(blocks, axis=1)[np.minimum(np.arange(len(x)) // width, count - 1)]
    return np.asarray(np.maximum(near, np.median(rough[moves])) / 0.6745 / np.sqrt(70.0))


def usual_gap(x: Array) -> float:
    """Return the median gap between the values that a channel takes: its rounding where that is coarse."""
    gaps = np.diff(np.unique(x))
    return float(np.median(gaps)) if len(gaps) else 0.0


def quantum_at(x: Array, at: Index) -> Array:
    """Return the gap between each reading and the next other values of the record, (m,): its rounding at most."""
    known = np.unique(x)
    if len(known) < 3:
        return np.full(len(at), np.inf)
    gaps = np.diff(known)
    place = np.searchsorted(known, x[at])
    below = gaps[np.clip(place - 1, 0, len(gaps) - 1)]
    above = gaps[np.clip(place, 0, len(gaps) - 1)]
    return np.asarray(
        np.maximum(np.where(place > 0, below, above), np.where(place < len(gaps), above, below))
    )


def last_moving(samples: Array, period: float) -> int:
    """Return the last reading of a channel, shape (n,), about which it oscillates."""
    return int(np.flatnonzero(swing_of(samples, period).steady()).max(initial=0))
