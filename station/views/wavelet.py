"""The Wavelet tab: scalogram with its ridge, envelope with its fit, instantaneous frequency, orders, backbone."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.wavelet.wavelet import WaveletResult
from station.story.identification import Identification
from station.text.numbers import scale
from station.views import log, palette, plots
from station.views.figure import figure, legend
from station.views.plots import SCREEN

ROOT = "/wavelet"


def write(stream: rr.RecordingStream, name: str, result: Identification) -> None:
    """Log what the wavelet identification found; only the refusal when there is none."""
    found = result.wavelet
    if found is None:
        log.markdown(stream, f"{ROOT}/refusal", f"## Not identified\n\n{result.refusals.get('wavelet', '')}")
        return
    factor, unit = scale("displacement", result.decay.unit)
    time, trusted = found.time, found.trusted
    hilbert = found.hilbert_envelope * factor
    log.series(
        stream,
        f"{ROOT}/envelope/hilbert",
        time,
        hilbert,
        f"Hilbert, for reference [{unit}]",
        palette.REFERENCE,
        1.0,
    )
    log.series(
        stream,
        f"{ROOT}/envelope/measured",
        time,
        found.envelope * factor,
        f"ridge [{unit}]",
        palette.MEASURED,
        4.0,
    )
    log.series(
        stream, f"{ROOT}/envelope/model", time, found.envelope_fit * factor, f"fit [{unit}]", palette.WAVELET
    )
    frequency = np.where(trusted, found.frequency, np.nan)
    log.series(stream, f"{ROOT}/frequency", time, frequency, "instantaneous frequency [Hz]", palette.WAVELET)
    _scalogram(stream, found)
    orders(stream, f"{ROOT}/orders", found.mse_percent_by_order, found.order, palette.css(palette.WAVELET))
    _backbone(stream, found, factor, unit)


def _scalogram(stream: rr.RecordingStream, found: WaveletResult) -> None:
    drawn, (axis,) = figure(7.2, 3.6)
    modulus = found.scalogram / max(float(np.max(found.scalogram)), np.finfo(float).tiny)
    shown = axis.pcolormesh(
        found.scalogram_time, found.scalogram_frequency, 20 * np.log10(np.maximum(modulus, 1e-4)),
        cmap="magma", vmin=-60, vmax=0, shading="nearest", rasterized=True,
    )  # fmt: skip
    trusted = found.trusted
    low, high = found.scalogram_frequency.min(), found.scalogram_frequency.max()
    axis.plot(found.time, np.clip(found.frequency, low, high), ":", color="white", lw=1.0)
    axis.plot(
        found.time[trusted],
        found.frequency[trusted],
        color="white",
        lw=1.8,
        label="ridge (dotted: not trusted)",
    )
    axis.set(xlabel="time [s]", ylabel="frequency [Hz]", ylim=(low, high))
    axis.grid(visible=False)
    legend(axis, "upper right", colour="white")
    bar = drawn.colorbar(shown, ax=axis, pad=0.01)
    bar.set_label("modulus [dB of its maximum]", color=palette.INK)
    bar.ax.tick_params(colors=palette.INK)
    bar.outline.set_visible(False)
    log.picture(stream, f"{ROOT}/scalogram", drawn, {"time": found.time, "ridge": found.frequency})


def orders(
    stream: rr.RecordingStream, path: str, errors: tuple[float, ...], chosen: int, colour: str
) -> None:
    """Log the error left against the order of damping, the paper's figure 3, on a logarithmic axis."""
    drawn, (axis,) = figure(4.2, 3.6)
    plots.orders(axis, errors, chosen, SCREEN, colour)
    axis.annotate(
        f"chosen: {chosen}", (chosen, errors[chosen]), xytext=(10, 16), textcoords="offset points",
        color=palette.INK,
    )  # fmt: skip
    numbers = {"order": [float(order) for order in range(len(errors))], "mse_percent": list(errors)}
    log.picture(stream, path, drawn, numbers)


def _backbone(stream: rr.RecordingStream, found: WaveletResult, factor: float, unit: str) -> None:
    drawn, (axis,) = figure(4.2, 3.6)
    spread = float(np.ptp(found.backbone_frequency)) if len(found.backbone_frequency) else 0.0
    half = max(0.6 * spread, 0.005 * float(np.median(found.frequency)))
    plots.backbone(axis, found, factor, unit, half, SCREEN, palette.css(palette.WAVELET))
    legend(axis, "lower left")
    numbers = {
        "frequency": found.backbone_frequency,
        "amplitude": found.backbone_amplitude,
        "fit": found.backbone_fit,
    }
    log.picture(stream, f"{ROOT}/backbone", drawn, numbers)


def tab(result: Identification) -> rrb.Container:
    """Return the layout of the tab."""
    found = result.wavelet
    if found is None:
        return rrb.Vertical(log.document("Wavelet", f"{ROOT}/refusal"), name="Wavelet")
    trusted = found.frequency[found.trusted]
    _, unit = scale("displacement", result.decay.unit)
    middle = float(np.median(trusted if len(trusted) else found.frequency))
    spread = float(np.percentile(np.abs(trusted - middle), 98)) if len(trusted) else 0.0
    half = max(1.5 * spread, 0.01 * middle)
    return rrb.Vertical(
        rrb.Horizontal(
            log.shown_picture("Scalogram and ridge", f"{ROOT}/scalogram"),
            log.shown_picture("Error against order", f"{ROOT}/orders"),
            log.shown_picture("Backbone", f"{ROOT}/backbone"),
            column_shares=[7.2, 4.2, 4.2],
        ),
        log.curves(f"Envelope [{unit}]", [f"{ROOT}/envelope/**"]),
        log.curve("Instantaneous frequency [Hz]", f"{ROOT}/frequency", (middle - half, middle + half)),
        row_shares=[1.35, 1, 0.8],
        name="Wavelet",
    )
