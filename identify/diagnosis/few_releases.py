"""Many releases: more effects than one are sought on a few of them, on a few cycles, and what is found is fitted to all.

What does not reach the floor on a few releases does not reach it on all, and every trial costs as much less.
"""

from dataclasses import dataclass
from typing import Self

from identify.diagnosis.suspects import Candidate, residual_lines, score_candidate
from identify.diagnosis.weak_presence import states_of_term
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import scales_of
from identify.fitting.segments import first_cycles
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay

_CYCLES = 30.0
"""Cycles of each of the two, at most: what a record of a few seconds has."""


@dataclass(frozen=True, eq=False)
class FewReleases:
    """The baseline of all releases, `whole`, that of a few of them, and the candidates as refitted to the few.

    `places` are those of the few among all.
    """

    whole: Baseline
    baseline: Baseline
    tried: tuple[Candidate, ...]
    places: tuple[int, ...]

    @classmethod
    def of(cls, whole: Baseline, tried: tuple[Candidate, ...]) -> Self:
        """Return the first cycles of the releases of the largest and the smallest amplitude; all where there are no more."""
        places = _chosen(whole.decays)
        if len(places) == len(whole.decays):
            return cls.all(whole, tried)
        decays = tuple(first_cycles(whole.decays[i], _CYCLES) for i in places)
        windows = tuple(
            whole.fit.windows[i].until(len(prepared.window))
            for i, prepared in zip(places, decays, strict=True)
        )
        base = _refitted(whole.fit, places, windows)
        baseline = Baseline(decays, base, tuple(whole.floors[i] for i in places))
        scales = scales_of(decays[0], residual_lines(base))
        goal = baseline.highest * base.degrees
        few = tuple(
            score_candidate(_refitted(c.fit, places, windows, goal), base, c.term, scales) for c in tried
        )
        return cls(whole, baseline, tuple(sorted(few, key=lambda c: c.score)), places)

    @classmethod
    def all(cls, whole: Baseline, tried: tuple[Candidate, ...]) -> Self:
        """Return all releases: nothing is searched on fewer."""
        return cls(whole, whole, tried, tuple(range(len(whole.decays))))

    def on_all(self, found: Fit) -> Fit:
        """Return a model that was found on the few, fitted to all releases."""
        if self.baseline is self.whole:
            return found
        base, count = self.whole.fit, len(self.whole.decays)
        start = base.point | {u.name: found.values[u.name].value for u in found.unknowns if u.window < 0}
        start |= _own_linear(base, found)
        for term in found.model.forces:
            if term.effect.name not in base.model:
                start |= states_of_term(base, term, start)
        for i in range(count):
            own = self.places.index(i) if i in self.places else None
            for u in found.unknowns:
                is_theirs = u.window == own or (own is None and u.window == 0 and u.id.role == "parameter")
                if u.window >= 0 and u.deviates < 0 and is_theirs:
                    start[str(u.id.of_release(i, count))] = found.values[u.name].value
        return fit(found.model, base.windows, start, base.frequency, near=True)

    def candidate_on_all(self, found: Candidate) -> Candidate:
        """Return a candidate that was found on the few, fitted to all releases."""
        if self.baseline is self.whole:
            return found
        base = self.whole.fit
        scales = scales_of(self.whole.decays[0], residual_lines(base))
        return score_candidate(self.on_all(found.fit), base, found.term, scales)


def _own_linear(base: Fit, found: Fit) -> dict[str, float]:
    """Return what each release has of its own beside the shared strengths of another fit, to a few of them, by name."""
    own = {
        (found.windows[u.window].release, u.id.parameter): found.values[u.name].value
        for u in found.unknowns
        if u.deviates >= 0
    }
    start = {}
    for u in base.unknowns:
        if u.deviates >= 0:
            shared = base.unknowns[u.deviates].name
            here = base.values[u.name].value + base.values[shared].value - found.values[shared].value
            start[u.name] = own.get((base.windows[u.window].release, u.id.parameter), here)
    return start


def _chosen(decays: tuple[PreparedDecay, ...]) -> tuple[int, ...]:
    """Return the places of the largest and of the smallest amplitude, in the order of the releases."""
    order = sorted(range(len(decays)), key=lambda i: -decays[i].amplitude)
    return tuple(sorted({order[0], order[-1]}))


def _refitted(found: Fit, places: tuple[int, ...], windows: tuple[FitWindow, ...], goal: float = 0.0) -> Fit:
    """Return a fit to all releases refitted to the `windows` of those in `places`.

    Left where it creeps to a `goal` of chi-square above 0.
    """
    return fit(found.model, windows, found.of_windows(places), found.frequency, near=True, goal=goal)
