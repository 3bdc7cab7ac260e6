"""The ladder of a session as a document: every step with its model, so that one can go back to it."""

from typing import Any, Self

from pydantic import Field

from daq.session import Session
from daq.storage import digest
from station.exits import UsageProblem
from station.results.documents import Document, Errors, Number, Part, picked, read_with_checksum, to_text
from station.results.models import ModelFile
from station.story.engineering_values import Weighing

LADDER = "ladder.json"
MODEL = "model.json"
REMEDY = "begin again with --reset"


class KeptStep(Part):
    """One step: what was added or removed, the model with its values, and its errors.

    `floor_percent` is what noise alone leaves of the motion, `at_floor` whether the model leaves no more. `nuisances` are
    the release's own values (state at the start, lag, gain, offsets), from which the same fit is found again at once.
    `begun_with` says which model it is that the ladder began with; "" above that step.
    """

    added: str = ""
    removed: str = ""
    model: ModelFile
    error: Errors
    floor_percent: Number
    at_floor: bool
    nuisances: dict[str, float]
    begun_with: str = ""

    @property
    def effects(self) -> list[str]:
        """The effects' names."""
        return self.model.names

    @property
    def began(self) -> str:
        """Which model it is that the ladder began with, in two words, as "usual model"."""
        return self.begun_with.split(",")[0].removeprefix("the ") or "first model"

    @property
    def name(self) -> str:
        """Which model it is, as "usual model" or "refined model"."""
        return self.began if self.begun_with else "refined model"

    def weighed(self, weighing: Weighing) -> dict[str, Any]:
        """Return the same with the mass in forces and strengths."""
        return {
            f"{entry.effect}.{name}": value
            for entry in self.model.effects
            for name, value in weighing.weighed(entry.effect, entry.parameters).items()
        }


class KeptLadder(Document):
    """All steps, the place of the present one, and why the refinement stopped.

    `seen` is the checksum of the file that it was read from, or is to replace (None for no file); it is not kept.
    """

    steps: tuple[KeptStep, ...] = Field(min_length=1)
    present: int = Field(ge=0)
    stopped_because: str = ""
    verdict: str | None = None
    seen: str | None = Field(default=None, exclude=True)

    @property
    def top(self) -> KeptStep:
        """The present step."""
        return self.steps[self.present]

    def with_(self, **changes: Any) -> Self:
        """Return a copy with some fields replaced."""
        return self.model_copy(update=changes)


def read_ladder(session: Session) -> KeptLadder | None:
    """Return the ladder of a session, None when there is none yet; UsageProblem when it was damaged."""
    found = read_with_checksum(session, LADDER, KeptLadder, REMEDY)
    if found is None:
        return None
    ladder, checksum = found
    if ladder.present >= len(ladder.steps):
        raise UsageProblem(
            f"{session.folder.name}: the present step of results/{LADDER} is not among its {len(ladder.steps)}; {REMEDY}"
        )
    return ladder.with_(seen=checksum)


def write_ladder(session: Session, ladder: KeptLadder) -> KeptLadder:
    """Write results/ladder.json and the present model, results/model.json, as one change; return the ladder as written.

    SessionChanged when the ladder that it continues is another by now: nothing is written then.
    """
    text = to_text(ladder)
    contents = {LADDER: text, MODEL: to_text(ladder.top.model)}
    session.write_results(contents, seen={LADDER: ladder.seen})
    return ladder.with_(seen=digest(text.encode()))


def ladder_document(session: Session, ladder: KeptLadder) -> dict[str, Any]:
    """Return the ladder under the keys that other programs rely on; the last step is the present model."""
    steps = ladder.steps[: ladder.present + 1]
    return {
        **picked(ladder, "format", "stopped_because", "verdict"),
        "session": session.folder.name,
        "steps": [
            {
                "added": step.added or None,
                "removed": step.removed or None,
                "effects": step.effects,
                "error": step.error.model_dump(),
                "parameters": {name: value.model_dump() for name, value in step.model.parameters.items()},
            }
            for step in steps
        ],
        "floor": {"motion_percent": ladder.top.floor_percent, "chi2": 1.0},
        "steps_above": len(ladder.steps) - len(steps),
        "model_file": str(session.results / MODEL),
    }
