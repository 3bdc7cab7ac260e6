"""The tabs of one identification: what was recorded, how its channels were aligned, the wavelet, and both results."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.arrays import Array
from station.story.identification import Identification
from station.text.content import facts, markdown
from station.text.identification_text import lag_words, told, uncorrected
from station.text.layout import sentence
from station.text.numbers import scale
from station.views import identification_figures as figures, log, palette
from station.views.overlay import alignment as picture_of_lag, overlay
from station.views.palette import Look


def capture(stream: rr.RecordingStream, look: Look, name: str, result: Identification) -> rrb.Container:
    """Show the channels as recorded (lost samples left out), the states of the mass, and the facts."""
    decay, kept = result.decay, result.decay.known
    views: list[rrb.View] = []
    for channel, recorded in decay.channels.items():
        factor, unit = scale(channel, decay.unit)
        title, shown = f"{channel.capitalize()} as recorded [{unit}]", np.where(kept, recorded, np.nan)
        line = (title, shown * factor, palette.CHANNEL[channel], 1.5)
        views.append(log.curves(stream, title, f"/capture/{channel}", decay.time, {"": line}))
    record = f"# {name}\n\n{markdown(told(name, result).brief[:1])}"
    return rrb.Horizontal(
        rrb.Vertical(*views, _states(stream, result), row_shares=[4.0] * len(views) + [1.2]),
        log.markdown(stream, "Record", "/capture/facts", record),
        column_shares=[2.4, 1],
        name="Capture",
    )


def _states(stream: rr.RecordingStream, result: Identification) -> rrb.View:
    release, rate = result.release, result.decay.rate
    changes = [(release.settle / rate, "free"), (release.end / rate, "stopped")]
    if release.rest[1] > release.rest[0]:
        changes.append((release.rest[0] / rate, "at rest"))
        changes.append((release.rest[1] / rate, "held"))
    if release.settle > release.index:
        changes.append((release.time_s, "letting go"))
    for time, state in sorted(changes):
        stream.set_time(log.TIMELINE, duration=time)
        stream.log("/capture/mass", rr.StateChange(state=state))
    stream.reset_time()
    return rrb.StateTimelineView(origin="/capture/mass", name="What the mass did")


def alignment(stream: rr.RecordingStream, look: Look, name: str, result: Identification) -> rrb.Container:
    """Show the channels over each other before and after, and what the lag would have spoiled."""
    words = markdown(facts([("lag", sentence(lag_words(result))), ("without it", uncorrected(result))]))
    views = [log.markdown(stream, "Lag", "/alignment/text", words)]
    shown = overlay(result)
    if shown is None:
        return rrb.Vertical(*views, name="Alignment")
    drawn = picture_of_lag(result, look)
    if drawn is not None:
        zoomed = log.picture(stream, "Close to a zero of the acceleration", "/alignment/zoom", drawn)
        views.insert(0, zoomed)
    unit = f"{result.decay.unit}/s^2"
    gain = 1.0 if result.alignment is None else result.alignment.gain.value
    acceleration = (f"acceleration [{unit}]", shown.acceleration, palette.ACCELERATION, 4.5)
    label = f"displacement, differentiated twice [{unit}]"
    pairs, left = [], {}
    for words, second, colour in (
        ("as recorded", shown.before, palette.WRONG),
        ("lag corrected", shown.after, palette.FORCE),
    ):
        key = words.replace(" ", "_")
        both = {"acceleration": acceleration, "displacement": (label, second, palette.DISPLACEMENT, 1.5)}
        pairs.append(log.curves(stream, f"Channels {words}", f"/alignment/{key}", shown.time, both))
        left[key] = (f"{words} [{unit}]", shown.acceleration - gain * second, colour, 1.5)
    return rrb.Vertical(
        rrb.Horizontal(*views),
        rrb.Horizontal(*pairs),
        log.curves(stream, "Difference of the two", "/alignment/difference", shown.time, left),
        row_shares=[1.25, 1, 1],
        name="Alignment",
    )


def wavelet(stream: rr.RecordingStream, look: Look, name: str, result: Identification) -> rrb.Container:
    """Show the scalogram with its ridge, the backbone, the envelope with its fit, and the instantaneous frequency."""
    found = result.wavelet
    if found is None:
        return refused(stream, "Wavelet", result.refusals.get("wavelet", ""))
    length = result.decay.unit
    factor, unit = scale("displacement", length)
    envelope = {
        "measured": (f"ridge [{unit}]", found.envelope * factor, palette.MEASURED, 4.0),
        "model": (f"fit [{unit}]", found.envelope_fit * factor, palette.WAVELET, 1.5),
    }
    trusted = np.where(found.trusted, found.frequency, np.nan)
    shown = ("Instantaneous frequency [Hz]", trusted, palette.WAVELET, 1.5)
    middle, half = figures.frequency_reach(found)
    pictures = (
        log.picture(stream, "Scalogram and ridge", "/wavelet/scalogram", figures.scalogram(found, look)),
        log.picture(stream, "Backbone", "/wavelet/backbone", figures.backbone(found, length, look)),
    )
    return rrb.Vertical(
        rrb.Horizontal(*pictures, column_shares=[7.2, 4.2]),
        log.curves(stream, f"Envelope [{unit}]", "/wavelet/envelope", found.time, envelope),
        log.curves(stream, shown[0], "/wavelet/frequency", found.time, {"": shown}, (middle - half, middle + half)),
        row_shares=[1.35, 1, 0.8],
        name="Wavelet",
    )  # fmt: skip


def refused(stream: rr.RecordingStream, name: str, reason: str) -> rrb.Container:
    """Show why a method found nothing."""
    path = f"/{name.lower().replace(' ', '_')}/refusal"
    return rrb.Vertical(log.markdown(stream, name, path, f"## Not identified\n\n{reason}"), name=name)


def results(stream: rr.RecordingStream, look: Look, name: str, result: Identification) -> rrb.Container:
    """Show both methods side by side, and the decay and the force as each rebuilds them over the measurement."""
    found, length, views = told(name, result), result.decay.unit, []
    if result.wavelet is not None:
        channel, time = result.wavelet.channel, result.wavelet.time
        units = (scale(channel, length), scale(channel, length, fine=True))
        views += _rebuilt(stream, "decay", time, result.rebuilt_decay(result.wavelet), units, palette.WAVELET)
    force = result.restoring_force
    if force is not None:
        unit, words = result.weighing.force_scale, result.weighing.worded()
        pair = (force.force, force.force_fit)
        views += _rebuilt(stream, words, force.time, pair, (unit, unit), palette.FORCE)
    words = f"**{found.headline}**\n\n{markdown(found.brief)}"
    text = log.markdown(stream, "Both methods", "/results/table", words)
    if not views:
        return rrb.Vertical(text, name="Results")
    rebuilt = rrb.Vertical(*views, row_shares=[1.6, 1.0] * (len(views) // 2))
    return rrb.Horizontal(text, rebuilt, column_shares=[1, 1.6], name="Results")


def _rebuilt(
    stream: rr.RecordingStream,
    what: str,
    time: Array,
    pair: tuple[Array, Array],
    units: tuple[tuple[float, str], tuple[float, str]],
    colour: log.Colour,
) -> list[rrb.View]:
    """Show a measurement with its model, and the residual in a finer unit; `units` are factor and name of both."""
    ((factor, unit), (fine, fine_unit)), (measured, model) = units, pair
    path = f"/results/{what.split()[0]}"
    lines = {
        "measured": (f"measured [{unit}]", measured * factor, palette.MEASURED, 4.5),
        "model": (f"model [{unit}]", model * factor, colour, 1.5),
    }
    left = (f"{what.capitalize()}: measured less model [{fine_unit}]", (measured - model) * fine, colour, 1.5)
    return [
        log.curves(stream, f"{what.capitalize()}: measurement and model", path, time, lines),
        log.curves(stream, left[0], f"{path}_error", time, {"": left}),
    ]
