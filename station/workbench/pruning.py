"""Dropping what is not needed: effects without which the misfit hardly rises are taken out, the least useful first."""

from identify.diagnosis.ladder import without_needless_effects
from station.operations.refining import Refinement, step_again
from station.results.ladder import KeptLadder, kept_step, write_ladder
from station.workbench.names import plain


def drop_needless(refinement: Refinement) -> tuple[KeptLadder, str]:
    """Return the ladder without needless effects, which is kept, and a sentence; what the first step has stays."""
    ladder = refinement.ladder
    stays = set(ladder.steps[0].effects)
    dropped = without_needless_effects(step_again(refinement, ladder.top), stays)
    if not dropped:
        return ladder, "Each effect that was added is needed: without it the misfit rises."
    expressions = ladder.top.model.expressions
    steps = (*ladder.steps[: ladder.present + 1], *(kept_step(step, expressions) for step in dropped))
    words = "taken out, since the misfit hardly rises without: " + ", ".join(
        plain(r.removed) for r in dropped
    )
    changed = ladder.with_(steps=steps, present=len(steps) - 1, stopped_because=words, verdict=None)
    return write_ladder(refinement.session, changed), f"{words[:1].upper()}{words[1:]}."
