"""The example firmware with a holder keeps the rules of the page, whatever a host sends in whatever order."""

import math
import random
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from bench_host import BenchHost, Board
from c_compiler import C_FOLDER, SANITIZE, STRICT, build

from firmware_protocol import (
    NO_SAMPLE,
    Ack,
    Describe,
    HelloRequest,
    Hold,
    Holder,
    HolderReason,
    HolderState,
    Message,
    Nack,
    NackCode,
    Release,
    Start,
    Stop,
    TimeSync,
    encode,
)

SOURCES = [C_FOLDER / name for name in ("main.c", "board.c", "hardware_host.c")]
SPEED, SILENCE_S = 4, 8  # so the board waits two seconds of this computer's clock, which may be busy
FREE, MOVING, HELD, LETTING_GO = list(HolderState)[:4]
W0, DRY, VISCOUS = math.sqrt(13115 / 21.36), 0.13, 0.277  # of hardware_host.c
NOISE_M = 5e-6


@pytest.fixture(scope="module")
def firmware(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("c") / "firmware"
    return build(out, SOURCES, [*STRICT, *SANITIZE, "-DBOARD_HOLDER=1", f"-DHOLDING_SILENCE_S={SILENCE_S}"])


class Rig(BenchHost):
    """A host that says something so often that the board does not take it for gone."""

    spoke = 0.0
    asked = 0
    """How many frames had come when it last asked to move: what the board then does is told behind these."""

    def ask(self, message: Message, seconds: float = 5) -> Ack | Nack:
        if isinstance(message, Hold | Release):
            self.asked = len(self.frames)
        return super().ask(message, seconds)

    def listen(self, mute: bool = False) -> None:
        """Read what comes, and be heard every 0.1 s."""
        if not mute and time.monotonic() - self.spoke > 0.1:
            self.spoke = time.monotonic()
            self.send(TimeSync(1))
        self.read(0.01)

    def ticket(self) -> int:
        self.send(HelloRequest())
        return self.next(Holder).ticket

    def next_report(
        self, wanted: Callable[[Holder], bool], mute: bool = False, begin: int | None = None
    ) -> Holder:
        """The first HOLDER since it last asked to move, or from the frame `begin` on, that is as wanted."""
        begin, until = self.asked if begin is None else begin, time.monotonic() + 10
        while time.monotonic() < until:
            found = [f.message for f in self.frames[begin:] if isinstance(f.message, Holder)]
            if any(map(wanted, found)):
                return next(filter(wanted, found))
            self.listen(mute)
        raise AssertionError(f"no such HOLDER; the last ones: {self.messages(Holder)[-3:]}")

    def until(self, state: HolderState, mute: bool = False) -> Holder:
        return self.next_report(lambda report: report.state is state, mute=mute)

    def freshly(self, request: Callable[[int], Hold | Release]) -> Ack | Nack:
        """Ask with a new ticket; once more if this busy computer let it grow old."""
        for _ in range(5):
            answer = self.ask(request(self.ticket()))
            if not (isinstance(answer, Nack) and answer.code is NackCode.STALE):
                break
        return answer

    def hold(self, displacement: float) -> Ack | Nack:
        return self.freshly(lambda ticket: Hold(ticket, displacement))

    def held(self, displacement: float) -> Holder:
        assert isinstance(self.hold(displacement), Ack)
        return self.until(HELD)

    def refused(self, request: Hold | Release) -> NackCode:
        answer = self.ask(request)
        assert isinstance(answer, Nack), answer
        return answer.code

    def take(self, samples: int) -> None:
        """Take so many samples more."""
        last, until = len(self.samples()) + samples, time.monotonic() + 60  # to end a hang
        while len(self.samples()) < last:
            assert time.monotonic() < until, f"no samples; the last frames: {self.frames[-3:]}"
            self.listen()

    def displacements(self) -> list[float]:
        """Of all samples of the last capture, m; nothing may be missing."""
        samples = self.samples()
        assert sorted(samples) == list(range(len(samples)))
        return [struct.unpack("<2h", samples[i])[0] * 1e-6 for i in range(len(samples))]


@pytest.fixture
def board(firmware: Path) -> Iterator[Board]:
    board = Board(firmware, "--speed", str(SPEED))
    yield board
    board.end()


@pytest.fixture
def rig(board: Board) -> Iterator[Rig]:
    rig = Rig(board.path)
    yield rig
    rig.close()


def test_it_declares_its_holder_behind_the_description(rig: Rig) -> None:
    rig.hello()
    report = rig.next(Holder)
    assert (report.low, report.high, report.silence_s) == (0.0, pytest.approx(0.025), SILENCE_S)
    assert (report.state, report.reason, report.sample) == (FREE, HolderReason.BOOT, NO_SAMPLE)


def test_without_a_holder_it_understands_nothing_of_it(tmp_path: Path) -> None:
    board = Board(build(tmp_path / "plain", SOURCES, STRICT))
    rig = Rig(board.path)
    for request in (Hold(0, 0.01), Release(0)):
        assert rig.refused(request) is NackCode.NOT_UNDERSTOOD
    rig.hello()
    rig.next(Describe)
    assert rig.messages(Holder) == []
    rig.close()
    board.end()


def test_the_mass_is_taken_held_and_let_go_at_the_sample_that_is_told(rig: Rig) -> None:
    rig.ask(Start())
    report = rig.held(0.012)
    assert (report.displacement, report.reason) == (pytest.approx(0.012), HolderReason.REQUEST)
    rig.take(200)
    assert isinstance(rig.freshly(Release), Ack)
    freed = rig.until(FREE)
    rig.take(400)
    rig.stop()
    x = rig.displacements()
    assert x[freed.sample - 64 : freed.sample - 1] == pytest.approx([0.012] * 63, abs=6 * NOISE_M)
    # Half a period later it has lost what friction takes, at the first turning point below 0.
    half = math.pi / W0
    turning = -(0.012 - DRY / W0**2) * math.exp(-VISCOUS / 2 * half) + DRY / W0**2
    at = freed.sample + round((half + 0.0013) * 256)
    # One sample from the turning point the curve has fallen by (w dt)^2 / 2 = 0.5 %.
    assert min(x[at - 2 : at + 3]) == pytest.approx(turning, rel=5e-3, abs=6 * NOISE_M)
    # Let go within the sample before the one told: it has left its place by a (5 dt)^2 / 2 = 1.4 mm five samples on.
    assert x[freed.sample + 5] < 0.012 - 0.5e-3


@pytest.mark.parametrize("wrong", [0.0251, -0.0001, 1e300, -math.inf, math.nan])
def test_a_displacement_beyond_the_limits_is_refused_and_nothing_moves(rig: Rig, wrong: float) -> None:
    answer = rig.hold(wrong)
    assert isinstance(answer, Nack)
    assert answer.code is NackCode.LIMIT
    assert rig.ticket()
    assert rig.messages(Holder)[-1].state is FREE


def test_orders_that_make_no_sense_are_refused(rig: Rig) -> None:
    assert rig.refused(Release(0)) is NackCode.NOTHING_HELD
    hold = Hold(rig.ticket(), 0.012)
    assert isinstance(rig.ask(hold), Ack)
    moving = rig.until(MOVING)
    assert rig.refused(Release(moving.ticket)) is NackCode.NOTHING_HELD
    assert rig.refused(Hold(moving.ticket, 0.01)) is NackCode.BUSY
    assert isinstance(rig.ask(hold), Ack)  # once more: its answer was lost
    assert rig.refused(Hold(hold.ticket, 0.013)) is NackCode.STALE


def test_a_ticket_serves_once_and_not_after_a_reset(rig: Rig, firmware: Path) -> None:
    hold = Hold(rig.ticket(), 0.012)
    rig.ask(hold)
    release = Release(rig.until(HELD).ticket)
    assert isinstance(rig.ask(release), Ack)
    assert isinstance(rig.ask(release), Ack)
    assert rig.refused(hold) is NackCode.STALE
    again = Board(firmware, "--speed", str(SPEED))
    other = Rig(again.path)
    assert other.refused(release) is NackCode.NOTHING_HELD
    assert other.refused(hold) is NackCode.STALE
    assert other.ticket() != release.ticket
    assert other.messages(Holder)[-1].reason is HolderReason.BOOT
    other.close()
    again.end()


def test_a_held_mass_is_taken_to_another_displacement(rig: Rig) -> None:
    rig.held(0.012)
    assert isinstance(rig.hold(0.005), Ack)
    rig.ask(Start())
    there = pytest.approx(0.005)
    rig.next_report(lambda report: report.state is HELD and report.displacement == there)
    rig.take(200)
    assert rig.displacements()[-16:] == pytest.approx([0.005] * 16, abs=6 * NOISE_M)


def went_back_slowly(x: list[float]) -> bool:
    """At 5 mm/s at most: what it moves in half a second, noise aside; and never through 0."""
    fastest = max(abs(a - b) for a, b in zip(x[128:], x, strict=False))
    return fastest < 0.005 / 2 + 12 * NOISE_M and min(x) > -6 * NOISE_M and abs(x[-1]) < 6 * NOISE_M


@pytest.mark.parametrize("when", [MOVING, HELD])
@pytest.mark.parametrize("what", ["stop", "silence", "hang up", "open"])
def test_it_lets_go_slowly_when(rig: Rig, board: Board, when: HolderState, what: str) -> None:
    rig.ask(Start())
    rig.hold(0.012)
    rig.until(when)
    begin = rig.asked
    if what == "stop":
        rig.send(Stop())
    elif what != "silence":
        board.tell(what)
    reasons = {"stop": "STOP", "silence": "SILENCE", "hang up": "SILENCE", "open": "CONTACT"}
    why = HolderReason[reasons[what]]
    report = rig.next_report(lambda report: report.reason is why, mute=what == "silence")
    if when is HELD:
        assert report.state is LETTING_GO
        assert rig.refused(Hold(report.ticket, 0.01)) is NackCode.BUSY
        assert rig.refused(Release(report.ticket)) is NackCode.NOTHING_HELD
    if report.state is not FREE:
        report = rig.next_report(lambda report: report.state is FREE, begin=begin)
    assert report.sample == NO_SAMPLE
    if what == "stop":
        rig.stop()
        rig.frames = []
        assert isinstance(rig.ask(Start()), Ack)
    rig.take(400)
    rig.stop()
    assert went_back_slowly(rig.displacements())
    answer = rig.hold(0.3)
    assert isinstance(answer, Nack)
    assert answer.code is (NackCode.HOLDER if what == "open" else NackCode.LIMIT)


def test_a_carriage_that_does_not_reach_its_end_switch_is_stuck(rig: Rig, board: Board) -> None:
    board.tell("block")
    assert isinstance(rig.hold(0.01), Ack)
    report = rig.until(FREE)
    assert (report.reason, report.displacement) == (HolderReason.FAULT, 0.0)


def test_a_line_that_echoes_or_repeats_is_no_host(rig: Rig) -> None:
    rig.held(0.002)
    begin, until = len(rig.frames), time.monotonic() + (SILENCE_S + 6) / SPEED
    while time.monotonic() < until:
        rig.send_bytes(encode(TimeSync(5, 77), rig.sequence) + encode(TimeSync(5), 9999))
        rig.sequence += 1
        time.sleep(0.02)
        rig.read(0.0)
    reasons = {f.message.reason for f in rig.frames[begin:] if isinstance(f.message, Holder)}
    assert HolderReason.SILENCE in reasons


def test_old_tickets_and_wrong_orders_never_move_the_mass(rig: Rig) -> None:
    rng, old = random.Random(11), [0, 1, 2**32 - 1]
    rig.ask(Start())
    for _ in range(300):
        word = rng.choice(("hold", "release", "sync", "hello", "stop", "start"))
        if word in ("hold", "release"):
            ticket = rng.choice(old)
            request = Hold(ticket, rng.uniform(-0.1, 0.1)) if word == "hold" else Release(ticket)
            assert rig.refused(request) in (NackCode.STALE, NackCode.NOTHING_HELD)
        elif word == "hello":
            rig.send(HelloRequest())
        else:
            rig.send({"sync": TimeSync(1), "stop": Stop(), "start": Start()}[word])
    assert {report.state for report in rig.messages(Holder)} == {FREE}
    rig.stop()
    assert max(map(abs, rig.displacements()[-200:] or [0.0])) < 6 * NOISE_M
