"""The Wavelet tab: scalogram with its ridge, envelope with its fit, instantaneous frequency, orders, backbone."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from station.story.identification import Identification
from station.text.numbers import scale
from station.views import identification_figures as figures
from station.views import log, palette

ROOT = "/wavelet"


def write(stream: rr.RecordingStream, name: str, result: Identification) -> None:
    """Log what the wavelet identification found; only the refusal when there is none."""
    found = result.wavelet
    if found is None:
        log.markdown(stream, f"{ROOT}/refusal", f"## Not identified\n\n{result.refusals.get('wavelet', '')}")
        return
    factor, unit = scale("displacement", result.decay.unit)
    time, trusted = found.time, found.trusted
    curves = (
        ("hilbert", found.hilbert_envelope, "Hilbert, for reference", palette.REFERENCE, 1.0),
        ("measured", found.envelope, "ridge", palette.MEASURED, 4.0),
        ("model", found.envelope_fit, "fit", palette.WAVELET, 1.5),
    )
    for what, values, label, colour, width in curves:
        name = f"{label} [{unit}]"
        log.series(stream, f"{ROOT}/envelope/{what}", time, values * factor, name, colour, width)
    frequency = np.where(trusted, found.frequency, np.nan)
    log.series(stream, f"{ROOT}/frequency", time, frequency, "instantaneous frequency [Hz]", palette.WAVELET)
    log.picture(stream, f"{ROOT}/scalogram", figures.scalogram(found, palette.SCREEN))
    log.picture(stream, f"{ROOT}/orders", figures.orders(result, palette.SCREEN))
    log.picture(stream, f"{ROOT}/backbone", figures.backbone(found, result.decay.unit, palette.SCREEN))


def tab(result: Identification) -> rrb.Container:
    """Return the layout of the tab."""
    found = result.wavelet
    if found is None:
        return rrb.Vertical(log.document("Wavelet", f"{ROOT}/refusal"), name="Wavelet")
    _, unit = scale("displacement", result.decay.unit)
    middle, half = figures.frequency_reach(found)
    return rrb.Vertical(
        rrb.Horizontal(
            log.shown_picture("Scalogram and ridge", f"{ROOT}/scalogram"),
            log.shown_picture("Backbone", f"{ROOT}/backbone"),
            column_shares=[7.2, 4.2],
        ),
        rrb.Horizontal(
            log.curves(f"Envelope [{unit}]", [f"{ROOT}/envelope/**"]),
            log.shown_picture("Error against order, by both methods", f"{ROOT}/orders"),
            column_shares=[6.0, 5.4],
        ),
        log.curve("Instantaneous frequency [Hz]", f"{ROOT}/frequency", (middle - half, middle + half)),
        row_shares=[1.35, 1, 0.8],
        name="Wavelet",
    )
