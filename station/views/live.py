"""The live view of a capture: levels and both channels as they come, the trigger, the losses."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from daq.capture import CaptureObserver
from daq.recording import Array, Channel, Gap
from firmware_protocol import Hello
from station.text.numbers import scale_as_recorded
from station.views import log, palette
from station.views.viewer import HOST, free_port, start, wait_for

APPLICATION = "free-decay-station-live"  # of its own: the viewer keeps one layout for each application
ROOT = "/live"


class LiveView(CaptureObserver):
    """Draws a capture under way; give it to the capture as its observer."""

    def __init__(self, stream: rr.RecordingStream, rate: float) -> None:
        self._stream = stream
        self._channels: tuple[Channel, ...] = ()
        self._rate = rate if rate > 0 else 1.0
        self._now = 0.0

    def connected(self, hello: Hello, channels: tuple[Channel, ...]) -> None:
        """Lay out one curve for each channel."""
        self._channels = channels
        for channel in channels:
            colour = palette.CHANNEL.get(channel.quantity, palette.MEASURED)
            _, unit = scale_as_recorded(channel.quantity, channel.unit)
            style = rr.SeriesLines(
                colors=colour, names=f"{channel.name} [{unit}]", widths=1.5, aggregation_policy="MinMax"
            )
            self._stream.log(f"{ROOT}/{channel.name}", style, static=True)
        self._stream.send_blueprint(layout(channels))
        self._say(f"connected: {hello.board}, firmware {hello.firmware}")

    def state(self, name: str, detail: str) -> None:
        """Mark what the station is doing."""
        self._stream.set_time(log.TIMELINE, duration=self._now)
        self._stream.log(f"{ROOT}/station", rr.StateChange(state=name))
        self._say(f"{name}: {detail}" if detail else name)

    def block(self, first_index: int, samples: Array) -> None:
        """Draw a block of samples, shape (channels, n), SI."""
        times = (first_index + np.arange(samples.shape[1])) / self._rate
        self._now = float(times[-1])
        for channel, values in zip(self._channels, samples, strict=True):
            factor, _ = scale_as_recorded(channel.quantity, channel.unit)
            self._stream.send_columns(
                f"{ROOT}/{channel.name}",
                indexes=[rr.TimeColumn(log.TIMELINE, duration=times)],
                columns=rr.Scalars.columns(scalars=values * factor),
            )

    def loss(self, gap: Gap) -> None:
        """Write a loss into the log."""
        self._say(f"lost {gap.count} samples from {gap.first} on ({gap.reason})", rr.TextLogLevel.WARN)

    def _say(self, text: str, level: str = rr.TextLogLevel.INFO) -> None:
        self._stream.set_time(log.TIMELINE, duration=self._now)
        self._stream.log(f"{ROOT}/events", rr.TextLog(text, level=level))
        self._stream.reset_time()


def layout(channels: tuple[Channel, ...]) -> rrb.Blueprint:
    """Return the live layout: the channels, the state of the station, its log; it follows the newest sample."""
    views: list[rrb.View] = [
        log.over_time(channel.name.capitalize(), f"{ROOT}/{channel.name}") for channel in channels
    ]
    curves = rrb.Vertical(
        *views,
        rrb.StateTimelineView(origin=f"{ROOT}/station", name="Station"),
        row_shares=[4.0] * len(views) + [1.2],
    )
    events = rrb.TextLogView(origin=f"{ROOT}/events", name="What happened")
    return log.blueprint([rrb.Horizontal(curves, events, column_shares=[2, 1], name="Live")], follow=True)


@contextmanager
def live_viewer(rate: float) -> Iterator[tuple[int, LiveView]]:
    """Open a viewer window for one capture; give its port, and the view to give to the capture. It stays open afterwards."""
    port = free_port()
    start("--port", str(port), "--hide-welcome-screen")
    wait_for(port)
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.connect_grpc(f"rerun+http://{HOST}:{port}/proxy")
    try:
        yield port, LiveView(stream, rate)
    finally:
        stream.flush()
        stream.disconnect()
