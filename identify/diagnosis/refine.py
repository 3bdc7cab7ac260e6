"""Refinement: from a release to the ladder on which the error falls to the floor."""

from collections.abc import Sequence

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.ladder import Ladder, Progress
from identify.effects.effect import Effect
from identify.free_decay import FreeDecay
from identify.model.model import Model
from identify.preprocessing.prepared_decay import PreparedDecay


def refine(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
    model: Model | None = None,
    *,
    library: tuple[Effect, ...] | None = None,
    known: dict[str, float] | None = None,
    worth: float = 0.0,
    progress: Progress = lambda step, words: None,
) -> Ladder:
    """Add what is missing until nothing is, and take out again what is no longer needed; see `diagnose`."""
    return diagnose(decays, model, library=library, known=known, worth=worth).refine(progress)
