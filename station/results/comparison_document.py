"""A comparison as a document: what `--json` prints and `results/comparison.json` keeps."""

from pydantic import Field

from station.results.documents import (
    ChannelNoise,
    Document,
    Errors,
    FreeRunErrors,
    ModelSummary,
    Number,
    Numbers,
    Part,
)
from station.story.compared import Compared

NAME = "comparison.json"


class Place(Part):
    """One place at which the model fails, in words and numbers."""

    kind: str
    text: str
    size: Number
    std: Number
    largest: Number
    unit: str
    significance: Number


class Cycles(Part):
    """The errors cycle by cycle: amplitudes in the unit of the displacement, energies per unit mass."""

    time_s: Numbers = Field(validation_alias="time")
    amplitude: Numbers
    frequency_error_percent: Numbers = Field(validation_alias="frequency_error")
    frequency_error_std: Numbers
    energy_error: Numbers
    energy_error_std: Numbers
    free_run_misfit: Numbers


class ComparisonDocument(Document):
    """A model beside a measurement: how large its errors are, and where.

    `model_is` says which model it is, `model_remark` why it is not another. `error` is that of the `pieces` in which a
    long record is judged, `one_run` that of one free run from the release to the end; `floor_percent` is what noise alone
    leaves of the force.
    """

    session: str
    model: ModelSummary
    error: FreeRunErrors
    floor_percent: Number = Field(validation_alias="force_floor")
    noise_floor: dict[str, ChannelNoise] = Field(validation_alias="floor")
    summary: str
    cause: str
    places: list[Place]
    cycles: Cycles
    unit: str
    model_is: str = "the usual model"
    model_remark: str = ""
    pieces: int = 1
    one_run: Errors | None = None


def comparison_document(compared: Compared) -> ComparisonDocument:
    """Make the document of a comparison."""
    found = compared.comparison
    fit = compared.baseline.stated(compared.baseline.fit)
    return ComparisonDocument.of(
        found,
        format=1,
        session=compared.name,
        model=ModelSummary.of(fit, names=fit.model.names, equation=fit.model.equation),
        error=compared.error,
        model_is=compared.words,
        model_remark=compared.remark,
        pieces=compared.pieces,
        one_run={
            "force_mse_percent": found.force_error,
            "motion_percent": found.motion_error,
            "chi2": found.chi_square,
        },
        cycles=Cycles.of(found.cycles, free_run_misfit=found.free_run_misfit),
    )
