"""An identification as a document: what `--json` prints and `results/identification.json` keeps."""

import numpy as np
from pydantic import Field

from station.results.documents import Document, EstimateDocument, Number, Part
from station.story.identification import Identification
from station.story.preparation import MOTION, Options

NAME = "identification.json"


class RecordDocument(Part):
    """What was recorded; the noise of each channel is its standard deviation, None without that channel."""

    rate_hz: float = Field(validation_alias="rate")
    samples: int
    lost_samples: int
    channels: list[str]
    unit: str
    mass_kg: float | None = Field(validation_alias="mass")
    mass_std_kg: float | None = Field(validation_alias="mass_std")
    rate_std_hz: float | None = Field(None, validation_alias="rate_std")
    noise: dict[str, Number]


class ReleaseDocument(Part):
    """When and how the mass was released, and the spans (s) of rest and free motion."""

    time_s: float
    std_s: Number
    kind: str
    amplitude: Number
    index: int
    end_s: float
    rest_s: tuple[float, float]


class AlignmentDocument(Part):
    """By how much the displacement is late, and the gain between the channels."""

    lag_s: EstimateDocument = Field(validation_alias="lag")
    gain: EstimateDocument
    method: str
    caution: str


class MethodDocument(Part):
    """What both methods find: stiffness and damping, and why the order was chosen."""

    stiffness: EstimateDocument
    damping: list[EstimateDocument]
    order: int
    reason: str
    mse_percent_by_order: list[Number]
    stiffness_by_order: dict[str, EstimateDocument]
    stiffness_per_mass: EstimateDocument


class WaveletDocument(MethodDocument):
    """What the wavelet found; `clock` says where the recorder's clock limits it."""

    stiffness_reason: str
    channel: str
    clock: str = ""


class RestoringForceDocument(MethodDocument):
    """What the restoring force surface found."""

    significance_percent: dict[str, Number]
    offset: EstimateDocument
    mass: EstimateDocument | None
    source: str


class AdequacyDocument(Part):
    """Whether the identified model explains its record: its residual, and how well methods and clock agree."""

    effects: list[str]
    chi2: Number = Field(validation_alias="chi_square")
    chi2_std: Number = Field(validation_alias="chi_square_std")
    motion_percent: Number
    adequate: bool
    quotable: bool
    apart: str
    sigmas: Number
    doubt: str = ""


class OrdersDocument(Part):
    """The highest order of damping and the orders of stiffness that were tried, and whether the operator chose them."""

    max_order: int
    stiffness_orders: list[int]
    chosen: bool = Field(validation_alias="orders_chosen")


class IdentificationDocument(Document):
    """One release, identified; what could not be had is None, and `refusals` says why."""

    session: str
    record: RecordDocument
    release: ReleaseDocument
    alignment: AlignmentDocument | None
    wavelet: WaveletDocument | None
    restoring_force: RestoringForceDocument | None
    refusals: dict[str, str]
    adequacy: AdequacyDocument | None = None
    orders: OrdersDocument | None = None

    @property
    def chosen(self) -> tuple[str, ...]:
        """The effects of the identified model where the operator chose its orders; none where nobody did."""
        if self.orders is None or not self.orders.chosen or self.adequacy is None:
            return ()
        return tuple(self.adequacy.effects)


def identification_document(
    name: str, result: Identification, options: Options | None = None
) -> IdentificationDocument:
    """Make the document of the identification of the session `name`; `options` are those that it was made with."""
    decay, release, rate = result.decay, result.release, result.decay.rate
    return IdentificationDocument.of(
        result,
        format=1,
        session=name,
        record=RecordDocument.of(
            decay,
            samples=len(decay),
            lost_samples=result.lost_samples,
            channels=[name for name in MOTION if getattr(decay, name) is not None],
            noise={name: getattr(decay, f"noise_{name}") for name in MOTION},
        ),
        release=ReleaseDocument.of(
            release,
            amplitude=amplitude(result),
            end_s=release.end / rate,
            rest_s=(release.rest[0] / rate, release.rest[1] / rate),
        ),
        orders=options,
    )


def amplitude(result: Identification) -> float | None:
    """Measure how far the mass was from its rest at the release, m or rad, or None.

    Signed where it was held away and the displacement was measured: its mean before the release less its
    mean over the last tenth of the record. Otherwise the envelope at the start of the ridge.
    """
    displacement, rest = result.decay.displacement, result.release.rest
    if result.release.kind == "displaced" and displacement is not None and rest[1] > rest[0]:
        valid = result.decay.valid
        kept = np.ones(len(displacement), dtype=bool) if valid is None else valid
        held = displacement[rest[0] : rest[1]][kept[rest[0] : rest[1]]]
        tail = slice(len(displacement) - len(displacement) // 10, None)
        if len(held) and kept[tail].any():
            return float(np.mean(held) - np.mean(displacement[tail][kept[tail]]))
    if result.wavelet is not None and len(result.wavelet.envelope):
        return float(result.wavelet.envelope[0])
    return None
