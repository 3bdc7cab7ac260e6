"""The board's rules for its holder: limits, fresh commands, silence. It moves nothing that these do not allow.

All of `docs/protocol.md`, "Holding and letting go", from the board's side. `at` is the holder's clock (see `holder`),
`now` the caller's; both in s.
"""

from __future__ import annotations

import math

from firmware_protocol import (
    NO_SAMPLE,
    Frame,
    Hold,
    Holder as Report,
    HolderReason,
    HolderState,
    Message,
    NackCode,
    Release,
    TimeSync,
)
from mocks.holder import Holder

SILENCE_S = 2.0
REPORT_S = 0.25
FREE, MOVING, HELD, LETTING_GO = (
    HolderState.FREE,
    HolderState.MOVING,
    HolderState.HELD,
    HolderState.LETTING_GO,
)

Refusal = tuple[NackCode, str]


class Holding:
    """State and ticket of one board's holder from boot to boot; `rate` is that of the samples, Hz."""

    def __init__(self, holder: Holder, boot_id: int, now: float) -> None:
        self.holder = holder
        self.rate = 1.0
        self.state = FREE
        self._reason = HolderReason.BOOT
        self._displacement = 0.0
        self._ticket = boot_id
        self._done: Hold | Release | None = None
        self._heard = self._said = now
        self._sequence: int | None = None
        self._changed = False
        self._renew()

    def report(self) -> Report:
        """Return the message about the holder."""
        held = self._displacement if self.state is not FREE else 0.0
        limits = (self.holder.low, self.holder.high, SILENCE_S)
        since = self.holder.released_at
        sample = NO_SAMPLE if since is None else max(math.ceil((since - self.holder.origin) * self.rate), 0)
        return Report(*limits, self._ticket, self.state, self._reason, held, sample)

    def hear(self, frame: Frame, now: float) -> None:
        """Note that a host is there: by a request that is no echo and no repetition."""
        message = frame.message
        echo = isinstance(message, TimeSync) and message.board_time_us
        if not echo and frame.sequence != self._sequence:
            self._heard, self._sequence = now, frame.sequence

    def answer(self, request: Hold | Release, at: float) -> Refusal | None:
        """Carry out a request, or return why not: then nothing has changed."""
        self._advance(at)
        if request == self._done:  # Its ACK was lost: what it asked for still holds.
            self._changed = True
            return None
        refusal = self._refusal(request)
        if refusal is not None:
            return refusal
        if isinstance(request, Hold):
            self.holder.take(request.displacement, at)
            self._displacement = request.displacement
            self._become(MOVING, HolderReason.REQUEST)
        else:
            self.holder.let_go(at)
            self._become(FREE, HolderReason.REQUEST)
        self._done = request
        return None

    def _refusal(self, request: Hold | Release) -> Refusal | None:
        if isinstance(request, Release) and self.state is not HELD:
            return NackCode.NOTHING_HELD, "nothing is held"
        if request.ticket != self._ticket:
            return NackCode.STALE, "not a fresh command: its ticket is not the newest"
        if isinstance(request, Release):
            return None
        if self.state in (MOVING, LETTING_GO):
            return NackCode.BUSY, "the holder moves"
        if self.holder.contact_is_open:
            return NackCode.HOLDER, "the stop contact is open"
        if not self.holder.low <= request.displacement <= self.holder.high:  # also what is no number
            asked, low, high = (1e3 * x for x in (request.displacement, self.holder.low, self.holder.high))
            return NackCode.LIMIT, f"{asked:g} mm is outside this rig's limits, {low:g} to {high:g} mm"
        return None

    def let_go_slowly(self, reason: HolderReason, at: float) -> None:
        """Take a mass that is held or moved back to 0 and let go there; else nothing moves."""
        self._advance(at)
        if self.state in (MOVING, HELD):
            self.holder.take(0.0, at, slowly=True)
            self._displacement = 0.0
            self._become(LETTING_GO, reason)

    def contact(self, is_open: bool, at: float) -> None:
        """Note the stop contact; one that opens stops."""
        self.holder.contact_is_open = is_open
        if is_open:
            self.let_go_slowly(HolderReason.CONTACT, at)

    def poll(self, now: float, at: float) -> list[Message]:
        """Let go of the mass when no host is heard; return the reports that are due."""
        if now - self._heard >= SILENCE_S:
            self._heard = now
            self._renew()
            self.let_go_slowly(HolderReason.SILENCE, at)
        self._advance(at)
        if not self._changed and (self.state is FREE or now - self._said < REPORT_S):
            return []
        self._changed, self._said = False, now
        return [self.report()]

    def _advance(self, at: float) -> None:
        if self.state in (MOVING, LETTING_GO) and self.holder.arrived(at):
            self.state = HELD if self.state is MOVING else FREE
            self._changed = True

    def _become(self, state: HolderState, reason: HolderReason) -> None:
        self.state, self._reason, self._changed, self._done = state, reason, True, None
        self._renew()

    def _renew(self) -> None:
        """Make the next ticket: another one for 2^32 times."""
        self._ticket = (self._ticket * 1664525 + 1013904223) & 0xFFFFFFFF
