"""A provisional verdict while the decay is still running: the part of it that has come, judged beside the capture."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from daq.capture import CaptureObserver
from daq.recording import Array, Channel
from firmware_protocol import Hello
from identify.diagnosis.diagnose import diagnose
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare

_SHARE = 0.4
"""Share of the record after which it is looked at: at less, slow decays have hardly begun."""


class Provisional(CaptureObserver):
    """Collects the samples of a capture, and judges them once with the releases before; `say` gets what is named."""

    def __init__(
        self,
        before: tuple[PreparedDecay, ...],
        rate: float,
        duration_s: float,
        say: Callable[[list[str]], None],
    ) -> None:
        self._before, self._rate, self._duration, self._say = before, rate, duration_s, say
        self._blocks: list[Array] = []
        self._channels: tuple[Channel, ...] = ()
        self._recorded = -1
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="provisional")
        self.named: list[str] | None = None

    def connected(self, hello: Hello, channels: tuple[Channel, ...]) -> None:
        """Note the channels."""
        self._channels = channels

    def state(self, name: str, detail: str) -> None:
        """Note that the decay has begun."""
        if name == "recording" and self._recorded < 0:
            self._recorded = 0

    def block(self, first_index: int, samples: Array) -> None:
        """Collect; judge when enough has come."""
        self._blocks.append(samples)
        if self._recorded < 0:
            return
        self._recorded += samples.shape[1]
        if self._recorded >= _SHARE * self._duration * self._rate:
            self._recorded = -(10**9)
            self._pool.submit(self._judge, np.concatenate(self._blocks, axis=1))

    def close(self) -> None:
        """Wait for nothing: what is not judged by now comes too late."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _judge(self, samples: Array) -> None:
        readings = {
            c.quantity: row
            for c, row in zip(self._channels, samples, strict=True)
            if c.quantity in ("displacement", "velocity", "acceleration")
        }
        try:
            found = diagnose((*self._before, prepare(FreeDecay(rate=self._rate, **readings))))
        except NotIdentifiable:
            return
        self.named = list(found.named)
        self._say(self.named)
