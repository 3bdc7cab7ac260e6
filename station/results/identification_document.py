"""An identification as a document: what `--json` prints and `results/identification.json` keeps."""

from typing import Any

from pydantic import AliasPath, Field

from identify.free_decay import CHANNELS
from station.results.documents import Document, picked, plain
from station.story.pipeline import Identification
from station.story.preparation import Options

NAME = "identification.json"
_METHOD = (
    "stiffness", "damping", "order", "reason", "mse_percent_by_order", "stiffness_by_order", "stiffness_per_mass",
)  # fmt: skip


class KeptIdentification(Document):
    """What is read again of a kept identification: the effects of its model, and at which orders; none where it has none.

    `chosen` says whether the operator chose the highest order of damping and the orders of stiffness.
    """

    effects: tuple[str, ...] = Field((), validation_alias=AliasPath("adequacy", "effects"))
    max_order: int = Field(0, validation_alias=AliasPath("orders", "max_order"))
    stiffness_orders: tuple[int, ...] = Field((), validation_alias=AliasPath("orders", "stiffness_orders"))
    chosen: bool = Field(False, validation_alias=AliasPath("orders", "chosen"))


def identification_document(
    name: str, result: Identification, options: Options | None = None
) -> dict[str, Any]:
    """Make the document of the identification of the session `name`; `options` are those that it was made with.

    What could not be had is None, and `refusals` says why.
    """
    decay, release, rate, found = result.decay, result.release, result.decay.rate, result.adequacy
    error = picked(
        None if found is None else found.error, "motion_percent", chi2="chi_square", chi2_std="floor_std"
    )
    record = {
        "samples": len(decay),
        "lost_samples": result.lost_samples,
        "channels": list(decay.channels),
        "noise": {name: getattr(decay, f"noise_{name}") for name in CHANNELS},
    }
    times = {
        "amplitude": result.amplitude,
        "end_s": release.end / rate,
        "rest_s": (release.rest[0] / rate, release.rest[1] / rate),
    }
    return plain(
        {
            "format": 1,
            "session": name,
            "record": record
            | picked(decay, "unit", rate_hz="rate", mass_kg="mass", mass_std_kg="mass_std", rate_std_hz="rate_std"),
            "release": times | picked(release, "time_s", "std_s", "kind", "index"),
            "alignment": picked(result.alignment, "gain", "method", "caution", lag_s="lag"),
            "wavelet": picked(result.wavelet, *_METHOD, "stiffness_reason", "channel", "clock"),
            "restoring_force": picked(
                result.restoring_force, *_METHOD, "significance_percent", "offset", "mass", "source"
            ),
            "refusals": result.refusals,
            "adequacy": None if found is None else error
            | picked(found, "effects", "adequate", "quotable", "apart", "sigmas", "doubt"),
            "orders": picked(options, "max_order", "stiffness_orders", chosen="orders_chosen"),
        }
    )  # fmt: skip
