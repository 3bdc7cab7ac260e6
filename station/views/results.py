"""The Results tab: both methods side by side, and the reconstruction over the measurement."""

import rerun as rr
import rerun.blueprint as rrb

from station.story.identification import Identification
from station.text.content import markdown
from station.text.identification_text import told
from station.text.numbers import scale
from station.views import log, palette
from station.views.log import Array

ROOT = "/results"


def write(stream: rr.RecordingStream, name: str, result: Identification) -> None:
    """Log the table, the decay rebuilt from the parameters, and the force rebuilt from its fit."""
    found = told(name, result)
    log.markdown(stream, f"{ROOT}/table", f"**{found.headline}**\n\n{markdown(found.brief)}")
    _decay(stream, result)
    _force(stream, result)


def _decay(stream: rr.RecordingStream, result: Identification) -> None:
    found = result.wavelet
    if found is None:
        return
    measured, model = result.rebuilt_decay(found)
    factor, unit = scale(found.channel, result.decay.unit)
    fine, fine_unit = scale(found.channel, result.decay.unit, fine=True)
    _pair(stream, "decay", found.time, measured * factor, model * factor, unit)
    log.series(
        stream, f"{ROOT}/decay_error", found.time, (measured - model) * fine, f"measured minus model [{fine_unit}]",
        palette.WAVELET,
    )  # fmt: skip


def _force(stream: rr.RecordingStream, result: Identification) -> None:
    found = result.restoring_force
    if found is None:
        return
    unit = f"{result.decay.unit}/s^2"
    _pair(stream, "force", found.time, found.force, found.force_fit, unit)
    log.series(
        stream, f"{ROOT}/force_error", found.time, found.force - found.force_fit, f"measured minus model [{unit}]",
        palette.FORCE,
    )  # fmt: skip


def _pair(
    stream: rr.RecordingStream, what: str, time: Array, measured: Array, model: Array, unit: str
) -> None:
    colour = palette.WAVELET if what == "decay" else palette.FORCE
    log.series(stream, f"{ROOT}/{what}/measured", time, measured, f"measured [{unit}]", palette.MEASURED, 4.5)
    log.series(stream, f"{ROOT}/{what}/model", time, model, f"model [{unit}]", colour, 1.5)


def tab(result: Identification) -> rrb.Container:
    """Return the layout of the tab."""
    views = []
    if result.wavelet is not None:
        _, left = scale(result.wavelet.channel, result.decay.unit, fine=True)
        views.append(log.curves("Decay: measured, and rebuilt from the parameters", [f"{ROOT}/decay/**"]))
        views.append(log.curve(f"Measured less rebuilt decay [{left}]", f"{ROOT}/decay_error"))
    if result.restoring_force is not None:
        views.append(log.curves("Restoring force per unit mass: measured, and its fit", [f"{ROOT}/force/**"]))
        views.append(
            log.curve(f"Measured less fitted force [{result.decay.unit}/s^2]", f"{ROOT}/force_error")
        )
    text = log.document("Both methods", f"{ROOT}/table")
    if not views:
        return rrb.Vertical(text, name="Results")
    shares = [1.6, 1.0] * (len(views) // 2)
    return rrb.Horizontal(
        text, rrb.Vertical(*views, row_shares=shares), column_shares=[1, 1.6], name="Results"
    )
