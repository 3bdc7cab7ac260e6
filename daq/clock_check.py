"""The uncertainty of a capture's sampling rate, by the board's clock and this computer's.

The result is always a number. Whatever was not checked may be wrong, so the less the clocks tell, the larger it is.
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from daq.clock import ClockFit, lasting_step
from daq.decode import BOARD, Assembly
from daq.recording import Suspicion

CLOCK_LIMIT = 0.005
"""Share by which the rate of a good recording may be off: 1 % of its stiffness. Values of a worse one are not quoted."""

EVEN_LIMIT = 2.5e-4
"""Share of a second by which samples may part from even times before it is said: 0.05 % of the stiffness at most."""

HOST_SHARE = 1e-4
"""What this computer's own clock may be off by: a crystal and its temperature, or a network that corrects it."""

UNCHECKED_SHARE = 0.1
"""What a clock may be off by that nothing was held against: an RC oscillator is sold as good to 10 %, and a loop that
waits and then reads and prints is slow by as much. A crystal is better, but nobody has seen one."""

SIGMAS = 5.0
LONGEST_DATA_S = 0.1
"""The most that DATA may hold, by the protocol; with less than a sample in that time, one sample."""


@dataclass(frozen=True)
class CheckedRate:
    """The standard error of the sampling rate (Hz), never unknown, and what is to be said of the clocks."""

    std: float
    suspicions: tuple[Suspicion, ...] = ()


def checked_rate(assembly: Assembly, against_host: bool = True) -> CheckedRate:
    """Decide how well the sampling rate of a capture is known.

    Without `against_host` the board is a simulation that keeps a time of its own, which no clock here can be held against.
    """
    said: list[Suspicion] = []
    share = _rate(assembly, against_host, said)
    uneven = _unevenness(assembly, said)
    if against_host and uneven < EVEN_LIMIT:
        uneven = max(uneven, _lasting_step(assembly, said))
    _statements(assembly, said)
    return CheckedRate(max(share, uneven) * assembly.rate, tuple(said))


def _rate(assembly: Assembly, against_host: bool, said: list[Suspicion]) -> float:
    """Return the share by which the rate may be off as a whole."""
    board, rate = assembly.samples.board_clock(), assembly.rate
    own = 0.0 if board is None else abs(board.rate / rate - 1)
    if board is not None and own > max(CLOCK_LIMIT, SIGMAS * board.std / rate):
        text = f"the board says {rate:g} Hz, but its own clock says {board.rate:.6g} Hz"
        said.append(Suspicion(True, text, "correct the firmware"))
    if not against_host:
        return max(own, HOST_SHARE)
    host = assembly.samples.host_clock()
    if host is None or not isfinite(host.std) or host.std > UNCHECKED_SHARE * rate:
        unchecked = "samples arrived " + ("fewer than 8 times" if host is None else "too unevenly")
        said.append(
            Suspicion(
                False,
                f"the sampling rate could not be checked: {unchecked}; the error of every value allows for a rate that is"
                f" off by {100 * UNCHECKED_SHARE:g} %",
                "take it again, for longer or over a line that does not hold samples back",
            )
        )
        return max(own, UNCHECKED_SHARE)
    off, std = abs(host.rate / rate - 1), host.std / rate
    share = max(own, _against(host, rate, assembly.clock_ppm))
    if off > max(CLOCK_LIMIT, SIGMAS * std):
        text = (
            f"the board says {rate:g} Hz, but {host.rate:.4g} samples came per second of this computer's"
            " clock: every frequency would be wrong by that factor"
        )
        said.append(Suspicion(True, text, "correct the rate in the firmware"))
    elif share > CLOCK_LIMIT and not said:
        text = (
            f"the sampling rate is known to {100 * share:.2g} % only: {rate:g} Hz by the board, {host.rate:.4g} ±"
            f" {host.std:.2g} Hz by this computer's clock; the error of the stiffness includes twice that"
        )
        advice = "take it again, for longer or over a line that does not hold samples back"
        said.append(Suspicion(False, text, advice))
    return share


def _against(host: ClockFit, rate: float, stated_ppm: float | None) -> float:
    """Return the share by which the rate may be off, by this computer's clock and by what the board states of its own.

    The smaller of the two errors counts, and at least what the two differ by. A statement counts where this computer's
    clock is sharp enough to refute a wrong rate, and does not refute it.
    """
    off, std = abs(host.rate / rate - 1), host.std / rate
    measured = max(std, HOST_SHARE)
    if stated_ppm is not None and SIGMAS * std <= CLOCK_LIMIT:
        stated = 1e-6 * stated_ppm
        if off <= stated + HOST_SHARE + 3.0 * std:
            measured = min(stated, measured)
    return max(off, measured)


def _unevenness(assembly: Assembly, said: list[Suspicion]) -> float:
    """Return the difference of the board's times from its indices in the recording, as a share of a second."""
    store, rate = assembly.samples, assembly.rate
    if assembly.origin == BOARD and len(store.stamps) > 1 and len(set(store.stamps.values())) == 1:
        said.append(
            Suspicion(
                False,
                "the board's clock stands still, so a gap in its sampling could not be seen",
                "send the time of the first sample in board_time_us",
            )
        )
        return 0.0
    inside = store.unevenness(assembly.start, assembly.stop)
    found = (
        inside if inside is not None and inside.share > EVEN_LIMIT else store.unevenness(0, assembly.expected)
    )
    if found is not None and found.share > EVEN_LIMIT:
        at = (found.index - assembly.start) / rate
        text = (
            f"the board's clock and its sample index differ by {found.step * rate:.3g} samples ({found.step:.3g} s) within"
            f" a second, {'at' if found is inside else 'outside the recording, at'} {at:.3f} s: samples were not taken"
            " at even times"
        )
        certain = found is inside and found.share > CLOCK_LIMIT
        said.append(Suspicion(certain, text, "correct the firmware's timer"))
    return 0.0 if inside is None else inside.share


def _lasting_step(assembly: Assembly, said: list[Suspicion]) -> float:
    """Return the lasting shift of the arrivals within the recording, as a share of a second."""
    arrivals = assembly.samples.arrivals
    found = lasting_step([stop for _, stop, _ in arrivals], [time for *_, time in arrivals])
    if found is None or found.index <= assembly.start or found.after >= assembly.stop:
        return 0.0
    between = (found.after - assembly.start) / assembly.rate, (found.index - assembly.start) / assembly.rate
    text = (
        f"from some time between {between[0]:.2f} s and {between[1]:.2f} s on all samples arrive"
        f" {1e3 * abs(found.step):.0f} ms {'later' if found.step > 0 else 'earlier'}: the board may have paused without"
        " counting"
    )
    said.append(
        Suspicion(False, text, "take it again; if it happens again, stamp DATA with the clock that samples")
    )
    return found.share


def _statements(assembly: Assembly, said: list[Suspicion]) -> None:
    """Say what the board states of its clock that cannot be, and DATA that hold more than the protocol allows."""
    if assembly.clock_claim:
        said.append(Suspicion(False, assembly.clock_claim, "correct CLOCK of the firmware"))
    held = float(np.median([count for count, *_ in assembly.samples.arrivals] or [0]))
    if assembly.origin == BOARD and held > max(LONGEST_DATA_S * assembly.rate, 1.0) + 1.0:
        text = (
            f"each DATA holds {held:g} samples, {held / assembly.rate:.3g} s; the protocol allows {LONGEST_DATA_S:g} s, so"
            " that times and losses can be checked"
        )
        said.append(Suspicion(False, text, "send DATA at least every 0.1 s"))
