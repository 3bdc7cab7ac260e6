"""A provisional answer while the decay is still running: the part of it that has come, weighed beside the capture."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from daq.capture import CaptureObserver
from daq.reading_flags import Flag
from daq.recording import Array, Channel, Gap, Mask, Recording
from daq.sensor_faults import sensor_faults
from firmware_protocol import Hello
from identify.diagnosis.diagnose import diagnose
from identify.errors import NotIdentifiable
from identify.formatting import among, plain_name
from identify.planning.hypotheses import Hypothesis, odds
from identify.planning.weighed_anew import weighed_anew
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from station.story.pipeline import silent
from station.story.preparation import Options, free_decay

_SHARE = 0.4
"""Share of the record after which it is looked at: at less, slow decays have hardly begun."""


class Provisional(CaptureObserver):
    """Collects the samples of a capture, and weighs them once; `say` gets the answer, a clause.

    All that it sees it passes on to another observer, `also`. With releases `before`, the `hypotheses` that they leave are
    refitted to them and to what has come; the first release is diagnosed by itself.
    """

    def __init__(
        self,
        before: tuple[PreparedDecay, ...],
        hypotheses: tuple[Hypothesis, ...],
        rate: float,
        duration_s: float,
        say: Callable[[str], None],
        also: CaptureObserver,
    ) -> None:
        self._also = also
        self._before, self._hypotheses = before, hypotheses
        self._enough, self._say = _SHARE * duration_s * rate, say
        self._rate = rate
        self._blocks: list[Array] = []
        self._channels: tuple[Channel, ...] = ()
        self._recorded = -1
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="provisional")
        self.answer = ""

    def connected(self, hello: Hello, channels: tuple[Channel, ...]) -> None:
        """Note the channels."""
        self._also.connected(hello, channels)
        self._channels = channels

    def state(self, name: str, detail: str) -> None:
        """Note that the decay has begun."""
        self._also.state(name, detail)
        if name == "recording" and self._recorded < 0:
            self._recorded = 0

    def block(self, first_index: int, samples: Array) -> None:
        """Collect; judge when enough has come."""
        self._also.block(first_index, samples)
        self._blocks.append(samples)
        if self._recorded < 0:
            return
        self._recorded += samples.shape[1]
        if self._recorded >= self._enough:
            came = np.concatenate(self._blocks, axis=1)
            self._pool.submit(self._weigh, came, came.shape[1] - self._recorded)
            self._recorded = -(10**9)

    def loss(self, gap: Gap) -> None:
        """Pass on."""
        self._also.loss(gap)

    def close(self) -> None:
        """Wait for nothing: what is not weighed by now comes too late."""
        self._say = silent
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _weigh(self, samples: Array, began: int) -> None:
        known: Mask = np.all(np.isfinite(samples), axis=0)
        recording = Recording(self._rate, self._channels, samples, known, trigger=began)
        flags = [run.flag for run in sensor_faults(recording).runs]
        if Flag.SATURATED in flags:  # what is cut off weighs for nothing
            return
        try:
            new = prepare(free_decay(recording, Options()))
            self.answer = self._of(new)
        except NotIdentifiable:
            return
        self._say(self.answer)

    def _of(self, new: PreparedDecay) -> str:
        if not self._before:
            named = diagnose(new).named
            return among([plain_name(name) for name in named]) if named else "nothing is named yet"
        found = weighed_anew(self._hypotheses, self._before, new)
        return f"{found[0].title}, odds {100.0 * odds(found)[0]:.0f} % among the open hypotheses"
