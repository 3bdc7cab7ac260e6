"""Leave one release out: what the physics found on all others predicts of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from identify.errors import NotIdentifiable
from identify.fitting.fit import Fit, fit
from identify.fitting.prediction import predict_windows


@dataclass(frozen=True)
class LeftOut:
    """The error on release `index` (from 0) of physics that was fitted to all the others.

    `chi_square` is reduced, in units of the noise; `motion_percent` the misfit of the free run in % of the rms of the
    displacement (or the first channel there is).
    """

    index: int
    chi_square: float
    motion_percent: float


def leave_one_out(found: Fit, releases: Sequence[Sequence[int]] | None = None) -> tuple[LeftOut, ...]:
    """Fit to all releases but one, hold the physics, refit the nuisances of the one left out; for each in turn.

    `releases` are the windows that belong to each release, where long ones were fitted in segments; else each window
    is one. Raises NotIdentifiable with a single release.
    """
    groups = [[i] for i in range(len(found.windows))] if releases is None else [list(g) for g in releases]
    if len(groups) < 2:
        raise NotIdentifiable("Leaving one release out needs at least two.")
    return tuple(_without(found, index, left) for index, left in enumerate(groups))


def _without(found: Fit, index: int, left: list[int]) -> LeftOut:
    kept = [i for i in range(len(found.windows)) if i not in left]
    windows = tuple(found.windows[i] for i in kept)
    others = fit(found.model, windows, found.of_windows(kept), found.frequency)
    left_windows = tuple(found.windows[i] for i in left)
    own = found.of_windows(left)
    physics = {unknown.name: others.point[unknown.name] for unknown in others.unknowns if unknown.window < 0}
    seen = predict_windows(found.model, physics, left_windows, own, found.frequency)
    return LeftOut(index, seen.chi_square, seen.motion_percent)
