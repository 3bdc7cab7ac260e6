"""Adding all that is missing: the ladder is kept rung by rung, so that each is seen as soon as it is found."""

from collections.abc import Callable

from identify.diagnosis.ladder import Rung
from identify.diagnosis.refine import refine
from station.operations.refining import Refinement
from station.results.ladder import KeptLadder, KeptRung, kept_rung, write_ladder
from station.results.models import known_model
from station.workbench.names import plain


def climb(refinement: Refinement, seen: Callable[[KeptLadder, str], None]) -> KeptLadder:
    """Add what is missing until nothing is; `seen` is called with the kept ladder after each rung, and what was done."""
    ladder = refinement.ladder
    top = ladder.top
    known = known_model(top.model, "the ladder", refinement.library)
    rungs = list(ladder.rungs[: ladder.present + 1])

    def on_rung(rung: Rung, words: str) -> None:
        if not rung.added and not rung.removed:
            return
        nonlocal ladder
        rungs.append(kept_rung(rung, top.model.expressions))
        ladder = _kept(refinement, ladder, rungs, (f"as found so far, {words}", None))
        seen(ladder, _said(rung))

    found = refine(
        refinement.prepared,
        known.model,
        library=refinement.library,
        known=known.values | top.nuisances,
        progress=on_rung,
    )
    return _kept(refinement, ladder, rungs, (found.stopped_because, found.verdict))


def _kept(
    refinement: Refinement, ladder: KeptLadder, rungs: list[KeptRung], why: tuple[str, str | None]
) -> KeptLadder:
    changed = ladder.with_(rungs=tuple(rungs), present=len(rungs) - 1, stopped_because=why[0], verdict=why[1])
    return write_ladder(refinement.session, changed)


def _said(rung: Rung) -> str:
    done = f"{plain(rung.added)} added" if rung.added else f"{plain(rung.removed)} taken out again"
    return f"{done}; looking for what else is missing"
