"""The ladder as it is kept in a session: every rung with its model, so that each can be gone back to."""

import math
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from daq.session import Session
from identify.diagnosis.refine import Rung
from station.exits import UsageProblem
from station.results.models import LARGEST, ModelFile, first_fault, model_file, written

LADDER = "ladder.json"
MODEL = "model.json"


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


class Errors(_Part):
    """The three errors of a rung, or of the floor; None where one is not finite."""

    force_mse_percent: float | None
    motion_percent: float | None
    chi2: float | None


class KeptRung(_Part):
    """One rung: what was added or removed, the model with its values, and its errors.

    `nuisances` are the release's own values (state at the start, lag, gain, offsets), from which the same fit is
    found again at once.
    """

    added: str = ""
    removed: str = ""
    model: ModelFile
    error: Errors
    chi2_std: float
    nuisances: dict[str, float]

    @property
    def effects(self) -> list[str]:
        """The effects' names."""
        return [entry.effect for entry in self.model.effects]

    @property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """All parameters by "effect.parameter": value, std, unit."""
        return {
            f"{entry.effect}.{name}": value.model_dump()
            for entry in self.model.effects
            for name, value in entry.parameters.items()
        }


class KeptLadder(_Part):
    """All rungs, the place of the present one, the floor, and why a climb stopped."""

    format: Literal[1] = 1
    rungs: tuple[KeptRung, ...] = Field(min_length=1)
    present: int = Field(ge=0)
    floor: Errors
    gain_percent: float | None = None
    stopped_because: str = ""
    verdict: str | None = None

    @property
    def top(self) -> KeptRung:
        """The present rung."""
        return self.rungs[self.present]

    def with_(self, **changes: Any) -> Self:
        """Return a copy with some fields replaced."""
        return self.model_copy(update=changes)


def kept(rung: Rung, expressions: tuple[str, ...]) -> KeptRung:
    """Return a rung as it is kept."""
    return KeptRung(
        added=rung.added,
        removed=rung.removed,
        model=model_file(rung.fit, expressions),
        error=Errors(
            force_mse_percent=_finite(rung.error.force_mse_percent),
            motion_percent=_finite(rung.error.motion_percent),
            chi2=_finite(rung.error.chi_square),
        ),
        chi2_std=rung.error.floor_std,
        nuisances={name: found.value for name, found in rung.fit.nuisances.items()},
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def read_ladder(session: Session) -> KeptLadder | None:
    """Return the ladder of a session, None when there is none yet; UsageProblem when it was damaged."""
    file = session.results / LADDER
    if not file.is_file():
        return None
    if file.stat().st_size > 50 * LARGEST:
        raise UsageProblem(f"{file} is larger than any ladder is; begin again with --reset")
    try:
        ladder = KeptLadder.model_validate_json(file.read_bytes())
    except ValidationError as error:
        raise UsageProblem(f"{file}: {first_fault(error)}; begin again with --reset") from error
    if ladder.present >= len(ladder.rungs):
        raise UsageProblem(
            f"{file}: the present rung is not among its {len(ladder.rungs)}; begin again with --reset"
        )
    return ladder


def write_ladder(session: Session, ladder: KeptLadder) -> None:
    """Write results/ladder.json, and the present model to results/model.json."""
    session.write_result(LADDER, ladder.model_dump_json(indent=1) + "\n")
    session.write_result(MODEL, written(ladder.top.model))


def ladder_document(session: Session, ladder: KeptLadder) -> dict[str, Any]:
    """Return the ladder under the keys that other programs rely on; the last rung is the present model."""
    rungs = ladder.rungs[: ladder.present + 1]
    return {
        "session": session.folder.name,
        "rungs": [
            {
                "added": rung.added or None,
                "removed": rung.removed or None,
                "effects": rung.effects,
                "error": rung.error.model_dump() | {"chi2_std": rung.chi2_std},
                "parameters": rung.parameters,
            }
            for rung in rungs
        ],
        "floor": ladder.floor.model_dump(),
        "stopped_because": ladder.stopped_because,
        "verdict": ladder.verdict,
        "rungs_above": len(ladder.rungs) - len(rungs),
        "model_file": str(session.results / MODEL),
    }
