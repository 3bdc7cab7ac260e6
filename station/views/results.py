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
    wavelet, force, length = result.wavelet, result.restoring_force, result.decay.unit
    if wavelet is not None:
        measured, model = result.rebuilt_decay(wavelet)
        shown, fine = (scale(wavelet.channel, length, fine=fine) for fine in (False, True))
        _pair(stream, "decay", wavelet.time, measured, model, (shown, fine), palette.WAVELET)
    if force is not None:
        unit = (1.0, f"{length}/s^2")
        _pair(stream, "force", force.time, force.force, force.force_fit, (unit, unit), palette.FORCE)


def _pair(
    stream: rr.RecordingStream, what: str, time: Array, measured: Array, model: Array,
    units: tuple[tuple[float, str], tuple[float, str]], colour: log.Colour,
) -> None:  # fmt: skip
    """Log a measurement, its model, and what the model leaves in a finer unit; `units` are factor and name of both."""
    (factor, unit), (fine, fine_unit) = units
    there, grey = f"{ROOT}/{what}", palette.MEASURED
    log.series(stream, f"{there}/measured", time, measured * factor, f"measured [{unit}]", grey, 4.5)
    log.series(stream, f"{there}/model", time, model * factor, f"model [{unit}]", colour)
    left = (measured - model) * fine
    log.series(stream, f"{there}_error", time, left, f"measured minus model [{fine_unit}]", colour)


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
