"""A comparison as a document: what `--json` prints and `results/comparison.json` keeps."""

from typing import Any

from pydantic import AliasChoices, Field, SerializerFunctionWrapHandler, model_serializer

from identify.comparison.compare import Comparison
from station.results.documents import (
    ChannelNoise,
    Document,
    Errors,
    EstimateDocument,
    Number,
    Numbers,
    Part,
    Table,
)
from station.story.compared import Compared

NAME = "comparison.json"


class ComparedModel(Part):
    """The model as fitted: its parameters, and the release's own values (state at the start, lag, gain, offsets)."""

    effects: list[str]
    equation: str
    parameters: dict[str, EstimateDocument]
    nuisances: dict[str, EstimateDocument]


class ComparisonErrors(Errors):
    """The three errors; `force_mse_percent_of_noise` is what noise alone leaves of the first."""

    force_mse_percent_of_noise: Number
    motion_channel: str
    chi2_std: Number


class Horizon(Part):
    """How far the free run goes."""

    seconds: float
    cycles: float


class Place(Part):
    """One place at which the model fails, in words and numbers."""

    kind: str
    text: str
    size: Number
    std: Number
    largest: Number
    unit: str
    significance: Number


class Kinematics(Part):
    """Whether the channels agree as derivatives of each other."""

    chi2: Number
    chi2_std: Number
    rms: Number
    rms_of_noise: Number
    unit: str


class Cycles(Part):
    """The errors cycle by cycle; the key of the amplitudes carries their unit, as `amplitude_m`."""

    time_s: Numbers
    amplitude: Numbers
    amplitude_unit: str = Field(exclude=True)
    frequency_error_percent: Numbers
    frequency_error_std: Numbers
    energy_error_per_mass: Numbers
    energy_error_std: Numbers
    free_run_misfit: Numbers

    @model_serializer(mode="wrap")
    def _with_unit(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        named = {"amplitude": f"amplitude_{self.amplitude_unit}"}
        return {named.get(key, key): value for key, value in serialize(self).items()}


class PhasePlaneDocument(Part):
    """The missing force per unit mass in bins of displacement (columns) and velocity (rows)."""

    displacement_edges: Numbers
    velocity_edges: Numbers
    force_per_mass: Table = Field(validation_alias=AliasChoices("force_per_mass", "force"))
    std: Table
    counts: Table


class HarmonicsDocument(Part):
    """The missing force at multiples of the frequency, in phase with displacement and with velocity."""

    order: Numbers
    with_displacement: Numbers
    with_velocity: Numbers
    significance: Numbers


class OneRun(Part):
    """What a model leaves of the whole record in one free run."""

    motion_percent: Number
    chi2: Number


class ComparisonDocument(Document):
    """A model beside a measurement: how large its errors are, and where.

    `model_is` says which model it is, `model_remark` why it is not another. `error` is that of the `pieces` in which a
    long record is judged, `one_run` that of one free run from the release to the end.
    """

    session: str
    model: ComparedModel
    error: ComparisonErrors
    horizon: Horizon
    noise_floor: dict[str, ChannelNoise]
    summary: str
    cause: str
    places: list[Place]
    kinematics: Kinematics | None
    cycles: Cycles
    phase_plane: PhasePlaneDocument
    harmonics: HarmonicsDocument
    model_is: str = "the usual model"
    model_remark: str = ""
    pieces: int = 1
    one_run: OneRun | None = None


def comparison_document(compared: Compared) -> ComparisonDocument:
    """Return a comparison as it is kept."""
    found, error = compared.comparison, compared.error
    fit = compared.baseline.stated(compared.baseline.fit)
    return ComparisonDocument.of(
        found,
        format=1,
        session=compared.name,
        model=ComparedModel.of(fit, effects=fit.model.names, equation=fit.model.equation),
        error=ComparisonErrors.of(
            error,
            force_mse_percent_of_noise=found.force_floor,
            motion_channel=found.motion_channel,
            chi2=error.chi_square,
            chi2_std=error.floor_std,
        ),
        model_is=compared.words,
        model_remark=compared.remark,
        pieces=compared.pieces,
        one_run={"motion_percent": found.motion_error, "chi2": found.chi_square},
        horizon={"seconds": found.horizon, "cycles": found.horizon_cycles},
        noise_floor=dict(found.floor),
        kinematics=_kinematics(found),
        cycles=_cycles(found),
    )


def _kinematics(found: Comparison) -> dict[str, Any] | None:
    checked = found.kinematics
    if checked is None:
        return None
    return {
        "chi2": checked.chi_square,
        "chi2_std": checked.chi_square_std,
        "rms": checked.rms,
        "rms_of_noise": checked.noise,
        "unit": f"{found.unit}/s^2",
    }


def _cycles(found: Comparison) -> dict[str, Any]:
    cycles = found.cycles
    return {
        "time_s": cycles.time,
        "amplitude": cycles.amplitude,
        "amplitude_unit": found.unit,
        "frequency_error_percent": cycles.frequency_error,
        "frequency_error_std": cycles.frequency_error_std,
        "energy_error_per_mass": cycles.energy_error,
        "energy_error_std": cycles.energy_error_std,
        "free_run_misfit": found.free_run_misfit,
    }
