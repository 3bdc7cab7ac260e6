"""Places: values of a suspect's inner parameters, and how much it would lower chi-square at each."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from identify.arrays import Array
from identify.diagnosis.null_lines import highest

LINEAR_UP_TO = 100.0
"""Reduced chi-square up to which one more effect moves the readings in proportion; beyond, gains are far beyond chance."""

Starts = tuple[dict[str, float], ...]
"""Starting values by their own names, of each place."""

NOWHERE: Mapping[tuple[str, ...], Starts] = MappingProxyType({})
"""No likeliest places of any variant."""


@dataclass(frozen=True, eq=False)
class Places:
    """Starting values of each place, and the `drops` (places, draws) of chi-square there; a peak may lie `between` two."""

    starts: Starts
    drops: Array
    between: bool = False

    @property
    def best(self) -> Array:
        """The largest drop over the places, (draws,)."""
        return highest(self.drops) if self.between else np.asarray(np.max(self.drops, axis=0, initial=0.0))

    def likeliest(self, draw: int) -> Starts:
        """Return the places at which the drop of one draw is larger than at their neighbours, the largest first."""
        drops = self.drops[:, draw]
        before, after = np.append(0.0, drops[:-1]), np.append(drops[1:], 0.0)
        tops = np.flatnonzero((drops > 0.0) & (drops >= before) & (drops >= after))
        return tuple(self.starts[i] for i in tops[np.argsort(-drops[tops], kind="stable")])
