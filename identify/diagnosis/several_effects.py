"""Several effects at once, where none reaches the floor alone: a law between the names, two effects, or three.

Of many releases two are searched (`few_releases`), and all judge what was found there.
"""

from dataclasses import dataclass, replace

from identify.diagnosis.few_releases import FewReleases
from identify.diagnosis.free_exponent import families
from identify.diagnosis.search import Pair, pairs
from identify.diagnosis.suspects import Candidate
from identify.diagnosis.triples import Triple, triple
from identify.effects.effect import Effect
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit


@dataclass(frozen=True, eq=False)
class Several:
    """What reaches the floor, one of `law`, `pair` and `triple` at most, and the fit that comes `closest` to it."""

    closest: Fit
    law: Candidate | None = None
    pair: Pair | None = None
    triple: Triple | None = None

    @property
    def reaches_floor(self) -> bool:
        """Whether anything was found that explains all."""
        return self.law is not None or self.pair is not None or self.triple is not None


def several_effects(baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]) -> Several:
    """Return what explains some releases together with other effects; `tried` are the single ones as fitted, best first.

    Where two of many releases mislead (what reaches the floor there does not on all), all are searched.
    """
    few = FewReleases.of(baseline, tried)
    found, of_few = _search(few, tried[0], library)
    misled = of_few and not found.reaches_floor and few.baseline is not baseline
    return _search(FewReleases.all(baseline, tried), tried[0], library)[0] if misled else found


def _search(few: FewReleases, best: Candidate, library: tuple[Effect, ...]) -> tuple[Several, bool]:
    """Return what reaches the floor of all releases, and whether anything reaches that of the few.

    `best` is the best single effect, of all releases.
    """
    whole = few.whole
    family = _law(few)
    law = None if family is None else few.candidate_on_all(family)
    if law is not None and law.plausible and whole.adequate(law.fit):
        return Several(law.fit, law=law), True
    closest, closest_of_few, of_few = best.fit, few.tried[0].fit, family is not None
    two = next((pair for pair in pairs(few.baseline, few.tried, library) if pair.plausible), None)
    if two is not None:
        of_few |= few.baseline.adequate(two.second.fit)
        closest_of_few = two.second.fit
        second = few.candidate_on_all(two.second)
        if second.score < best.score:
            closest = second.fit
            if whole.adequate(closest):
                return Several(closest, pair=Pair(two.first, second)), True
    three = triple(few.baseline, library, closest_of_few)
    if three is not None:
        of_few = True
        three = replace(three, fit=few.on_all(three.fit))
        if whole.adequate(three.fit):
            return Several(three.fit, triple=three), True
    return Several(closest), of_few


def _law(few: FewReleases) -> Candidate | None:
    """Return a law with a free exponent that reaches the floor of a few releases, where no named effect does."""
    found = families(few.baseline, few.tried)
    return next((c for c in found if c.plausible and few.baseline.adequate(c.fit)), None)
