"""The part of a record that is analysed, and why the analysis ends where it does."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from identify.arrays import Mask
from identify.preprocessing.aligned_decay import AlignedDecay
from identify.preprocessing.sampling import LONG_GAP
from identify.signal.running import runs_of

End = Literal["record_ends", "readings_missing", "motion_too_small", "motion_ends"]

_WORDS: dict[End, str] = {
    "record_ends": "to its end",
    "motion_too_small": "then too small compared with friction and noise",
    "motion_ends": "then the mass is at rest or moved again",
    "readings_missing": "",
}


@dataclass(frozen=True)
class RecordUse:
    """The part of a record that is analysed: from `begin_s` to `end_s` (s from its first reading) of `length_s`.

    `share` is that part of what follows the release. `ended` says why it ends there; where readings are missing,
    `missing_s` says how long.
    """

    begin_s: float
    end_s: float
    length_s: float
    share: float
    ended: End
    missing_s: float = 0.0

    @property
    def words(self) -> str:
        """The same in words, without a capital letter and a full stop."""
        if self.ended == "readings_missing":
            return (
                f"the analysis ends at {self.end_s:.2f} s, where {self.missing_s:.2g} s of readings are missing; "
                f"{100.0 * self.share:.0f} % of the record after the release was used"
            )
        return f"{self.begin_s:.2f} to {self.end_s:.2f} of {self.length_s:.2f} s, {_WORDS[self.ended]}"


def record_use(
    located: AlignedDecay, begin: float, end: float, cycle: float, *, to_the_end: bool
) -> RecordUse:
    """Describe the use of a record from `begin` to `end`, s since its release, of a motion whose cycle lasts `cycle` s.

    `to_the_end` says that the motion is followed as far as it was found, not only as far as it stands out.
    """
    record, released = located.recorded, located.release.time_s
    first, last, length = released + begin, released + end, len(record) / record.rate
    gap = _gap(~record.known, round(last * record.rate), LONG_GAP * cycle * record.rate)
    ended: End = "motion_ends" if to_the_end else "motion_too_small"
    missing = 0.0
    if gap is not None:
        ended, last, missing = "readings_missing", gap[0] / record.rate, (gap[1] - gap[0]) / record.rate
    elif length - last < LONG_GAP * cycle:
        ended = "record_ends"
    share = (last - first) / max(length - released, 1.0 / record.rate)
    return RecordUse(first, last, length, float(np.clip(share, 0.0, 1.0)), ended, missing)


def _gap(missing: Mask, at: int, fewest: float) -> tuple[int, int] | None:
    """Return the run of missing samples in which, or just before which, a sample lies, if it is long enough."""
    runs = (run for run in runs_of(missing) if run[0] - 1 <= at <= run[1] and run[1] - run[0] >= fewest)
    return next(runs, None)
