"""The noise floor of a record: its width is decided once, by the usual model, kept in the session, and stated everywhere."""

from dataclasses import replace

from pydantic import Field

from daq.session import Session
from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from identify.fitting.segments import segments_of
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import UsageProblem
from station.results.documents import Document, keep_document, read_document
from station.story.pipeline import silent

NAME = "noise_floor.json"


class NoiseFloor(Document):
    """The standard error of the reduced chi-square that a model which explains the record leaves."""

    session: str
    chi2_std: float = Field(gt=0, allow_inf_nan=False)


def with_floor(session: Session, prepared: PreparedDecay) -> PreparedDecay:
    """Return a release with the width of its session's floor, which is decided and kept where it was not yet."""
    try:
        kept = read_document(session, NAME, NoiseFloor, "it is made again")
    except UsageProblem:  # altered: it is made again
        kept = None
    if kept is None:
        try:
            width = fit_baseline(segments_of(prepared), base_model()).spread
        except NotIdentifiable:
            return prepared
        kept = NoiseFloor(format=1, session=session.folder.name, chi2_std=width)
        keep_document(session, NAME, kept, silent)  # the result that needs it tells
    return replace(prepared, floor_std=kept.chi2_std)
