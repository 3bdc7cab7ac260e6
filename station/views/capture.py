"""The Capture tab: what was recorded, where it was released, what was lost."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.free_decay import FreeDecay
from station.story.identification import Identification
from station.text.content import markdown
from station.text.identification_text import told
from station.text.numbers import scale
from station.views import log, palette


def channels(decay: FreeDecay) -> list[str]:
    """Return the names of the channels that were recorded."""
    return [name for name in palette.CHANNEL if getattr(decay, name) is not None]


def write(stream: rr.RecordingStream, name: str, result: Identification) -> None:
    """Log the channels as recorded (lost samples left out), the states of the mass, and the facts."""
    decay = result.decay
    kept = np.ones(len(decay), dtype=bool) if decay.valid is None else decay.valid
    for channel in channels(decay):
        factor, unit = scale(channel, decay.unit)
        values = np.where(kept, getattr(decay, channel), np.nan) * factor
        label = f"{channel} [{unit}]"
        log.series(stream, f"/capture/{channel}", decay.time, values, label, palette.CHANNEL[channel])
    _states(stream, result)
    log.markdown(stream, "/capture/facts", f"# {name}\n\n{markdown(told(name, result).brief[:1])}")


def _states(stream: rr.RecordingStream, result: Identification) -> None:
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


def tab(result: Identification) -> rrb.Container:
    """Return the layout of the tab."""
    views = [
        log.curve(
            f"{name.capitalize()} as recorded [{scale(name, result.decay.unit)[1]}]", f"/capture/{name}"
        )
        for name in channels(result.decay)
    ]
    states = rrb.StateTimelineView(origin="/capture/mass", name="What the mass did")
    return rrb.Horizontal(
        rrb.Vertical(*views, states, row_shares=[4.0] * len(views) + [1.2]),
        log.document("Record", "/capture/facts"),
        column_shares=[2.4, 1],
        name="Capture",
    )
