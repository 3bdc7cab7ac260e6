"""Adding all that is missing: the ladder is kept step by step, so that each is seen as soon as it is found."""

from collections.abc import Callable

from identify.diagnosis.ladder import Step
from identify.diagnosis.refine import refine
from station.operations.refining import Refinement
from station.results.ladder import KeptLadder, KeptStep, kept_step, write_ladder
from station.results.models import known_model
from station.workbench.names import plain


def climb(refinement: Refinement, seen: Callable[[KeptLadder, str], None]) -> KeptLadder:
    """Add what is missing until nothing is; `seen` is called with the kept ladder after each step, and what was done."""
    ladder = refinement.ladder
    top = ladder.top
    known = known_model(top.model, "the ladder", refinement.library)
    steps = list(ladder.steps[: ladder.present + 1])

    def on_step(step: Step, words: str) -> None:
        if not step.added and not step.removed:
            return
        nonlocal ladder
        steps.append(kept_step(step, top.model.expressions))
        ladder = _kept(refinement, ladder, steps, (f"as found so far, {words}", None))
        seen(ladder, _said(step))

    found = refine(
        refinement.prepared,
        known.model,
        library=refinement.library,
        known=known.values | top.nuisances,
        progress=on_step,
    )
    return _kept(refinement, ladder, steps, (found.stopped_because, found.verdict))


def _kept(
    refinement: Refinement, ladder: KeptLadder, steps: list[KeptStep], why: tuple[str, str | None]
) -> KeptLadder:
    changed = ladder.with_(steps=tuple(steps), present=len(steps) - 1, stopped_because=why[0], verdict=why[1])
    return write_ladder(refinement.session, changed)


def _said(step: Step) -> str:
    done = f"{plain(step.added)} added" if step.added else f"{plain(step.removed)} taken out again"
    return f"{done}; looking for what else is missing"
