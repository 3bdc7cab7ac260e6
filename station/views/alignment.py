"""The Alignment tab: the channels over each other before and after, and what the lag would have spoiled."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from station.story.identification import Identification
from station.text.identification_text import lag_words, uncorrected
from station.text.layout import sentence
from station.text.numbers import with_error
from station.views import log, palette
from station.views.figure import figure, legend
from station.views.log import Array
from station.views.plots import SCREEN, Look, literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PERIOD_SHARE = 0.05
TAIL = 7.0
NEAR = 0.06
"""Share of the period that is shown about a zero."""

CURVES = "/alignment"


@dataclass(frozen=True, eq=False)
class Overlay:
    """Acceleration and twice differentiated displacement under the same filter, m/s^2, on `time` (s)."""

    time: Array
    acceleration: Array
    before: Array
    after: Array


def overlay(result: Identification) -> Overlay | None:
    """Put both channels on one footing: the same Gaussian smooths one and differentiates the other twice.

    None without a displacement and an acceleration.
    """
    from scipy.ndimage import gaussian_filter1d

    recorded, aligned = result.decay, result.aligned
    if recorded.acceleration is None or recorded.displacement is None or aligned.displacement is None:
        return None
    width = max(1.5, PERIOD_SHARE * _period(result) * recorded.rate)
    edge = int(TAIL * width) + 1
    if 4 * edge >= len(recorded):
        return None
    inside = slice(edge, len(recorded) - edge)

    def second_derivative(displacement: Array) -> Array:
        smooth: Array = gaussian_filter1d(displacement, width, order=2, truncate=TAIL) * recorded.rate**2
        return smooth[inside]

    return Overlay(
        recorded.time[inside],
        gaussian_filter1d(recorded.acceleration, width, truncate=TAIL)[inside],
        second_derivative(recorded.displacement),
        second_derivative(aligned.displacement),
    )


def _period(result: Identification) -> float:
    found = result.restoring_force or result.wavelet
    if found is None or found.stiffness.value <= 0:
        return 0.0
    return float(2 * np.pi / np.sqrt(found.stiffness.value / (result.decay.mass or 1.0)))


def write(stream: rr.RecordingStream, name: str, result: Identification) -> None:
    """Log the overlaid channels, their difference before and after, and the lag in words."""
    log.markdown(stream, f"{CURVES}/text", summary(result))
    shown = overlay(result)
    if shown is None:
        return
    unit = f"{result.decay.unit}/s^2"
    for when, second in (("before", shown.before), ("after", shown.after)):
        log.series(
            stream, f"{CURVES}/{when}/acceleration", shown.time, shown.acceleration,
            f"acceleration [{unit}]", palette.ACCELERATION, 4.5,
        )  # fmt: skip
        log.series(
            stream, f"{CURVES}/{when}/displacement", shown.time, second,
            f"displacement, differentiated twice [{unit}]", palette.DISPLACEMENT,
        )  # fmt: skip
    gain = 1.0 if result.alignment is None else result.alignment.gain.value
    for when, second, colour in (
        ("as_recorded", shown.before, palette.WRONG),
        ("corrected", shown.after, palette.FORCE),
    ):
        difference = shown.acceleration - gain * second
        log.series(
            stream,
            f"{CURVES}/difference/{when}",
            shown.time,
            difference,
            f"{when.replace('_', ' ')} [{unit}]",
            colour,
        )
    _close_up(stream, result, shown)
    _damping(stream, result)


def about_zero(result: Identification, seen: Overlay) -> tuple[Array, NDArray[np.bool_]] | None:
    """Return the time (ms) about a zero of the acceleration one period after the release, and which samples are near.

    None where there is none.
    """
    rate = result.decay.rate
    period = _period(result) or 10 / rate
    later = np.flatnonzero(seen.time > result.release.settle / rate + period)
    crossings = np.flatnonzero(np.diff(np.sign(seen.acceleration[later])) > 0)
    if not len(crossings):
        return None
    time = seen.time - seen.time[later[crossings[0]]]
    return time * 1e3, np.abs(time) < max(NEAR * period, 4 / rate)


def draw_about_zero(axes: list["Axes"], result: Identification, seen: Overlay, look: Look) -> None:
    """Draw both channels about a zero of the acceleration, as recorded and with the lag corrected."""
    found = about_zero(result, seen)
    if found is None:
        return
    ms, near = found
    gain = 1.0 if result.alignment is None else result.alignment.gain.value
    for axis, second, title in zip(
        axes, (seen.before, seen.after), ("as recorded", "lag corrected"), strict=True
    ):
        axis.plot(
            ms[near], seen.acceleration[near], "o-", color=look.second, ms=4, lw=1, label="acceleration"
        )
        axis.plot(
            ms[near], gain * second[near], "x--", color=look.model, ms=4.5, lw=1,
            label="displacement, twice\ndifferentiated",
        )  # fmt: skip
        axis.set(title=title, xlabel="time about a zero of the acceleration [ms]")
    axes[0].set_ylabel(literal(f"acceleration [{result.decay.unit}/s^2]"))


def _close_up(stream: rr.RecordingStream, result: Identification, seen: Overlay) -> None:
    found = about_zero(result, seen)
    if found is None:
        return
    ms, near = found
    drawn, axes = figure(7.2, 3.3, 1, 2, sharey=True)
    draw_about_zero(axes, result, seen, SCREEN)
    legend(axes[1], "upper left")
    numbers = {"time_ms": ms, "acceleration": seen.acceleration, "before": seen.before, "after": seen.after}
    log.picture(stream, f"{CURVES}/zoom", drawn, {name: values[near] for name, values in numbers.items()})


def _damping(stream: rr.RecordingStream, result: Identification) -> None:
    found = [
        ("restoring force,\nas recorded", result.without_alignment, palette.WRONG),
        ("restoring force,\nlag corrected", result.restoring_force, palette.FORCE),
        ("wavelet (does not\nfeel the lag)", result.wavelet, palette.WAVELET),
    ]
    known = [
        (label, m.damping[1], colour) for label, m, colour in found if m is not None and len(m.damping) > 1
    ]
    if not known:
        return
    drawn, (axis,) = figure(5.4, 3.3)
    for row, (_, value, colour) in enumerate(known):
        axis.barh(row, value.value, color=palette.css(colour), height=0.55)
        axis.errorbar(value.value, row, xerr=2 * value.std, color=palette.INK, capsize=4, lw=1.2)
        axis.annotate(
            f"  {with_error(value.value, value.std)}",
            (max(value.value, 0.0) + 2 * value.std, row),
            va="center",
            fontsize=9,
            color=palette.INK,
        )
    axis.set_yticks(range(len(known)), [label for label, _, _ in known])
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    left, right = axis.get_xlim()
    axis.set_xlim(left, right + 0.45 * (right - left))
    axis.set_xlabel(literal(f"viscous damping mu_1 [{known[0][1].unit}], bars: 2 standard errors"))
    numbers = {"value": [value.value for _, value, _ in known], "std": [value.std for _, value, _ in known]}
    log.picture(stream, f"{CURVES}/damping", drawn, numbers)


def summary(result: Identification) -> str:
    """Say what the lag is and what it would have done, as markdown."""
    words = f"## Lag\n\n{sentence(lag_words(result))}"
    if result.alignment is not None:
        words += f"\n\nFound by {result.alignment.method}; no law of force is used."
    warning = uncorrected(result)
    return f"{words}\n\nWithout the correction {warning}." if warning else words


def tab(result: Identification) -> rrb.Container | None:
    """Return the layout of the tab."""
    if overlay(result) is None:
        return rrb.Vertical(log.document("Lag", f"{CURVES}/text"), name="Alignment")
    return rrb.Vertical(
        rrb.Horizontal(
            log.shown_picture("Close to a zero of the acceleration", f"{CURVES}/zoom"),
            log.shown_picture("What each method says of the viscous damping", f"{CURVES}/damping"),
            log.document("Lag", f"{CURVES}/text"),
            column_shares=[7.2, 5.4, 3.6],
        ),
        rrb.Horizontal(
            log.curves("Channels as recorded", [f"{CURVES}/before/**"]),
            log.curves("Channels, lag corrected", [f"{CURVES}/after/**"]),
        ),
        log.curves("Difference of the two, before and after", [f"{CURVES}/difference/**"]),
        row_shares=[1.25, 1, 1],
        name="Alignment",
    )
