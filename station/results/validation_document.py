"""A validation as a document: what `validate --json` prints and each session keeps as `results/validation.json`."""

from pydantic import Field

from identify.fitting.validation import UsualFrom, ValidationVerdict
from station.results.documents import Document, Number, Part, RefusedSession
from station.results.models import ModelFile

NAME = "validation.json"


class PredictionDocument(Part):
    """The residual of a session under held physics; null where the simulation diverges.

    `varied_percent` says by how much linear spring and damper were refitted, by parameter, in % of the squared frequency
    and of the mean loss of the session.
    """

    motion_percent: Number
    chi2: Number = Field(validation_alias="chi_square")
    varied_percent: dict[str, Number] = Field(validation_alias="varied")


class ValidatedDocument(Part):
    """One session: its prediction by the model and by the usual one, and whether the model's is clearly better or worse."""

    session: str
    model: PredictionDocument
    usual: PredictionDocument
    better: bool
    worse: bool


class ValidationDocument(Document):
    """The predictions of sessions by a model that was not fitted to them, and by the usual model.

    `source` is the file or session that the model is from and `fitted_to` the sessions that it was fitted to, as far as
    that is known; `usual_from` says where the usual model's values are from; `held` that linear spring and damper were
    held too. The errors are the medians over all sessions.
    """

    source: str
    fitted_to: list[str]
    model: ModelFile
    verdict: ValidationVerdict
    sentence: str
    usual_from: UsualFrom
    held: bool
    better: int
    worse: int
    motion_percent: Number
    usual_motion_percent: Number
    sessions: list[ValidatedDocument]
    skipped: list[RefusedSession]
