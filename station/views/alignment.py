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
    gain = 1.0 if result.alignment is None else result.alignment.gain.value
    for when, words, second, colour in (
        ("before", "as recorded", shown.before, palette.WRONG),
        ("after", "corrected", shown.after, palette.FORCE),
    ):
        for channel, values, name, tint, width in (
            ("acceleration", shown.acceleration, "acceleration", palette.ACCELERATION, 4.5),
            ("displacement", second, "displacement, differentiated twice", palette.DISPLACEMENT, 1.5),
        ):
            place = f"{CURVES}/{when}/{channel}"
            log.series(stream, place, shown.time, values, f"{name} [{unit}]", tint, width)
        place = f"{CURVES}/difference/{words.replace(' ', '_')}"
        difference = shown.acceleration - gain * second
        log.series(stream, place, shown.time, difference, f"{words} [{unit}]", colour)
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
