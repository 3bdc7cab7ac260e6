"""The Alignment tab: the channels over each other before and after, and what the lag would have spoiled."""

import rerun as rr
import rerun.blueprint as rrb

from station.story.identification import Identification
from station.text.identification_text import lag_words, uncorrected
from station.text.layout import sentence
from station.views import log, palette
from station.views.overlay import alignment, overlay

CURVES = "/alignment"


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
    drawn = alignment(result, palette.SCREEN)
    if drawn is not None:
        log.picture(stream, f"{CURVES}/zoom", drawn)


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
            log.document("Lag", f"{CURVES}/text"),
            column_shares=[7.2, 4.0],
        ),
        rrb.Horizontal(
            log.curves("Channels as recorded", [f"{CURVES}/before/**"]),
            log.curves("Channels, lag corrected", [f"{CURVES}/after/**"]),
        ),
        log.curves("Difference of the two, before and after", [f"{CURVES}/difference/**"]),
        row_shares=[1.25, 1, 1],
        name="Alignment",
    )
