"""The viewer's recording of a session: the record, its alignment, both identifications, and the steps of its refinement."""

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.formatting import plain_name
from identify.restoring_force.restoring_force import RestoringForceResult
from station.results.ladder import KeptLadder
from station.story.engineering_values import Weighing
from station.story.measured_curves import measured_curves
from station.story.pipeline import Identification
from station.text import ladder_text
from station.text.content import Equation, Paragraph, facts, markdown
from station.text.identification_text import lag_words, told, uncorrected
from station.text.layout import sentence
from station.text.numbers import scale, typeset, with_unit
from station.views import identification_figures as figures, log, palette
from station.views.comparison_figures import front
from station.views.diagnosis_figures import measured_curve
from station.views.figure import inked
from station.views.overlay import alignment as picture_of_lag, overlay
from station.views.palette import VIEWERS, Look

APPLICATION = "free-decay-station"
SURFACE = "/restoring_force/surface"
MOST_POINTS = 4000

Steps = tuple[KeptLadder, tuple[Fit, ...]]
"""A ladder, and the fits of its steps up to the present one."""


def write(
    file: Path, name: str, result: Identification, steps: Steps | None = None, *, dark: bool = True
) -> None:
    """Write the tabs of the session `name` to `file`, the last one in front, for a dark or a light viewer."""
    stream, look = rr.RecordingStream(APPLICATION, send_properties=False), VIEWERS[dark]
    stream.save(file)
    with inked(look):
        shown = [tab(stream, look, name, result) for tab in TABS]
        if steps is not None:
            shown.append(ladder(stream, look, name, *steps, result.weighing))
    layout = log.blueprint(shown, active=len(shown) - 1)
    stream.send_blueprint(layout, make_active=True, make_default=True)
    stream.flush()
    stream.disconnect()


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


def restoring_force(
    stream: rr.RecordingStream, look: Look, name: str, result: Identification
) -> rrb.Container:
    """Show the surface with the measured points, its sections, the orders, and the significance of the terms."""
    found = result.restoring_force
    if found is None:
        return refused(stream, "Restoring force", result.refusals.get("restoring_force", ""))
    _draw_surface(stream, found, result.weighing)
    surface = rrb.Spatial3DView(
        origin=SURFACE,
        name="Restoring force surface (points: measured)",
        line_grid=False,
        eye_controls=rrb.EyeControls3D(
            position=(-1.55, -2.9, 1.55), look_target=(0.08, 0.0, -0.1), eye_up=(0.0, 0.0, 1.0)
        ),
    )
    sections, orders = figures.sections(found, result.weighing, look), figures.orders(result, look)
    title = "Error against order by both methods, and significance of the terms"
    pictures = rrb.Vertical(
        log.picture(stream, "Sections", "/restoring_force/sections", sections),
        log.picture(stream, title, "/restoring_force/orders", orders),
    )
    return rrb.Horizontal(surface, pictures, column_shares=[1, 1.05], name="Restoring force")


def _draw_surface(stream: rr.RecordingStream, found: RestoringForceResult, weighing: Weighing) -> None:
    """Draw the fit and the measured points in a cube: displacement, velocity and force each from -1 to 1."""
    import matplotlib  # which the figures have loaded blind to the working folder
    from scipy.spatial import Delaunay

    every = max(1, len(found.force) // MOST_POINTS)
    plane = np.column_stack([found.displacement, found.velocity])[::every]
    size, newton = weighing.force_scale
    force, fit = size * found.force[::every], size * found.force_fit[::every]
    reach = np.array([*np.max(np.abs(plane), axis=0), max(np.max(np.abs(force)), np.max(np.abs(fit)))])
    points, placed = np.column_stack([plane, force]) / reach, np.column_stack([plane, fit]) / reach
    height = 0.5 + 0.5 * placed[:, 2]
    mesh = rr.Mesh3D(
        vertex_positions=placed,
        triangle_indices=Delaunay(placed[:, :2]).simplices,
        vertex_colors=matplotlib.colormaps["viridis"](height, bytes=True),
        face_rendering="DoubleSided",
    )
    steps = np.linspace(-1, 1, 5)
    floor = [[[x, -1, -1], [x, 1, -1]] for x in steps] + [[[-1, y, -1], [1, y, -1]] for y in steps]
    axes = [[[-1, -1, -1], [1, -1, -1]], [[1, -1, -1], [1, 1, -1]], [[-1, -1, -1], [-1, -1, 1]]]
    ends = [[0, -1.18, -1.02], [1.18, 0.1, -1.02], [-1, -1, 1.12]]
    colours = [palette.DISPLACEMENT, palette.VELOCITY, palette.ACCELERATION]
    factor, unit = scale("displacement", weighing.unit)
    names = [
        f"displacement ± {reach[0] * factor:.3g} {unit}",
        f"velocity ± {reach[1]:.3g} {weighing.unit}/s",
        typeset(f"{weighing.worded()} ± {reach[2]:.3g} {newton}"),
    ]
    for part, drawn in (
        ("fit", mesh),
        ("measured", rr.Points3D(points, colors=palette.MEASURED, radii=0.007)),
        ("floor", rr.LineStrips3D(floor, colors=palette.MEASURED, radii=0.002)),
        ("axes", rr.LineStrips3D(axes, colors=colours, radii=0.006)),
        ("names", rr.Points3D(ends, labels=names, colors=colours, radii=0.008, show_labels=True)),
    ):
        stream.log(f"{SURFACE}/{part}", drawn, static=True)


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


TABS = (capture, alignment, wavelet, restoring_force, results)


def ladder(
    stream: rr.RecordingStream,
    look: Look,
    name: str,
    kept: KeptLadder,
    fits: tuple[Fit, ...],
    weighing: Weighing,
) -> rrb.Container:
    """Show each step of a refinement, whatever the time is, the present one in front: the model closes in."""
    names = [f"{n}: {ladder_text.step_words(one)}" for n, one in enumerate(kept.steps)]

    def shown(place: int) -> rrb.Container:
        here, fit, step = f"/ladder/{place}", fits[place], kept.steps[place]
        drawn = front([(names[n], fits[n]) for n in sorted({0, place})], look)
        motion = log.picture(stream, "The model closes in on the measurement", f"{here}/motion", drawn)
        up_to = kept.with_(steps=kept.steps[: place + 1], present=place)
        up_to = up_to if place == kept.present else up_to.with_(stopped_because="")
        words = ladder_text.told(up_to, weighing)
        model = Paragraph(" + ".join(plain_name(effect) for effect in step.effects), weighing.words)
        equation = Equation((f"{' + '.join(weighing.terms(term.effect for term in fit.model.terms))} = 0",))
        values = facts((parameter, with_unit(value)) for parameter, value in step.weighed(weighing).items())
        parts = markdown((*words.brief, *words.more, model, equation, *values))
        text = f"# {name}, step {place}\n\n{words.headline}\n\n{parts}"
        beside = [log.markdown(stream, "This step", f"{here}/summary", text)]
        for curve in measured_curves(fit, step.model.expressions)[-1:]:
            drawn = measured_curve(curve, weighing, look)
            beside.append(log.picture(stream, "The measured curve", f"{here}/curve", drawn))
        column = rrb.Vertical(*beside, row_shares=[1.6, 1.0][: len(beside)])
        return rrb.Horizontal(motion, column, column_shares=[2.0, 1.0], name=names[place])

    return rrb.Tabs(*map(shown, range(len(fits))), active_tab=kept.present, name="Ladder")
