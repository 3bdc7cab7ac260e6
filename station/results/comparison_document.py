"""A comparison as a document: what `--json` prints and `results/comparison.json` keeps."""

from typing import Any

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from identify.comparison.compare import Comparison
from station.results.documents import Document, EstimateDocument, Number, Part
from station.results.documents import estimate_document as estimate
from station.story.compared import Compared

NAME = "comparison.json"


class ComparedModel(Part):
    """The model as fitted: its parameters, and the release's own values (state at the start, lag, gain, offsets)."""

    effects: list[str]
    equation: str
    parameters: dict[str, EstimateDocument]
    nuisances: dict[str, EstimateDocument]


class ComparisonErrors(Part):
    """The three errors; `force_mse_percent_of_noise` is what noise alone leaves of the first."""

    force_mse_percent: Number
    force_mse_percent_of_noise: Number
    motion_percent: Number
    motion_channel: str
    chi2: Number
    chi2_std: Number


class Horizon(Part):
    """How far the free run goes."""

    seconds: float
    cycles: float


class ChannelNoise(Part):
    """The noise of one channel, its standard error and where it was seen."""

    std: Number
    uncertainty: Number
    source: str


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

    time_s: list[Number]
    amplitude: list[Number]
    amplitude_unit: str = Field(exclude=True)
    frequency_error_percent: list[Number]
    frequency_error_std: list[Number]
    energy_error_per_mass: list[Number]
    energy_error_std: list[Number]
    free_run_misfit: list[Number]

    @model_serializer(mode="wrap")
    def _with_unit(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        named = {"amplitude": f"amplitude_{self.amplitude_unit}"}
        return {named.get(key, key): value for key, value in serialize(self).items()}


class PhasePlaneDocument(Part):
    """The missing force per unit mass in bins of displacement (columns) and velocity (rows)."""

    displacement_edges: list[float]
    velocity_edges: list[float]
    force_per_mass: list[list[Number]]
    std: list[list[Number]]
    counts: list[list[float]]


class HarmonicsDocument(Part):
    """The missing force at multiples of the frequency, in phase with displacement and with velocity."""

    order: list[float]
    with_displacement: list[Number]
    with_velocity: list[Number]
    significance: list[Number]


class ComparisonDocument(Document):
    """A model beside a measurement: how large its errors are, and where."""

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


def comparison_document(compared: Compared) -> ComparisonDocument:
    """Return a comparison as it is kept."""
    found = compared.comparison
    return ComparisonDocument(
        format=1,
        session=compared.name,
        model=_model(compared),
        error=ComparisonErrors(
            force_mse_percent=found.force_error,
            force_mse_percent_of_noise=found.force_floor,
            motion_percent=found.motion_error,
            motion_channel=found.motion_channel,
            chi2=found.chi_square,
            chi2_std=found.chi_square_std,
        ),
        horizon=Horizon(seconds=found.horizon, cycles=found.horizon_cycles),
        noise_floor={
            name: ChannelNoise(std=noise.std, uncertainty=noise.uncertainty, source=noise.source)
            for name, noise in found.floor.items()
        },
        summary=found.summary,
        cause=found.cause,
        places=[
            Place(
                kind=place.kind,
                text=place.text,
                size=place.size,
                std=place.std,
                largest=place.largest,
                unit=place.unit,
                significance=place.significance,
            )
            for place in found.places
        ],
        kinematics=_kinematics(found),
        cycles=_cycles(found),
        phase_plane=PhasePlaneDocument(
            displacement_edges=found.phase_plane.displacement_edges.tolist(),
            velocity_edges=found.phase_plane.velocity_edges.tolist(),
            force_per_mass=found.phase_plane.force.tolist(),
            std=found.phase_plane.std.tolist(),
            counts=found.phase_plane.counts.tolist(),
        ),
        harmonics=HarmonicsDocument(
            order=found.harmonics.order.tolist(),
            with_displacement=found.harmonics.with_displacement.tolist(),
            with_velocity=found.harmonics.with_velocity.tolist(),
            significance=found.harmonics.significance.tolist(),
        ),
    )


def _model(compared: Compared) -> ComparedModel:
    fit = compared.baseline.fit
    physics = {name for name in fit.values if "." in name and ".state" not in name}
    return ComparedModel(
        effects=list(fit.model.names),
        equation=fit.model.equation,
        parameters={name: estimate(value) for name, value in fit.values.items() if name in physics},
        nuisances={name: estimate(value) for name, value in fit.values.items() if name not in physics},
    )


def _kinematics(found: Comparison) -> Kinematics | None:
    checked = found.kinematics
    if checked is None:
        return None
    return Kinematics(
        chi2=checked.chi_square,
        chi2_std=checked.chi_square_std,
        rms=checked.rms,
        rms_of_noise=checked.noise,
        unit=f"{found.unit}/s^2",
    )


def _cycles(found: Comparison) -> Cycles:
    cycles = found.cycles
    return Cycles(
        time_s=cycles.time.tolist(),
        amplitude=cycles.amplitude.tolist(),
        amplitude_unit=found.unit,
        frequency_error_percent=cycles.frequency_error.tolist(),
        frequency_error_std=cycles.frequency_error_std.tolist(),
        energy_error_per_mass=cycles.energy_error.tolist(),
        energy_error_std=cycles.energy_error_std.tolist(),
        free_run_misfit=found.free_run_misfit.tolist(),
    )
