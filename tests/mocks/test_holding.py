"""A board with a holder keeps its rules, whatever a host sends in whatever order; its clock is the test's own."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from firmware_protocol import (
    NO_SAMPLE,
    Ack,
    ChannelDescription,
    Data,
    Decoder,
    HelloRequest,
    Hold,
    Holder,
    HolderReason,
    HolderState,
    Nack,
    NackCode,
    Release,
    Start,
    Stop,
    TimeSync,
    encode,
)
from mocks.acquisition import Acquisition, Converter
from mocks.board import Board
from mocks.holder import MAGNET_S, SLOWLY_M_S, Holder as Actuator
from mocks.holding import SILENCE_S
from mocks.misconfigurations import Misconfiguration
from mocks.sensors import Sensor
from mocks.testbed import Bench as Physics, Release as BoardError, simulate

STEP_M = 1e-6
RATE = 256.0
CHANNELS = (
    ChannelDescription("x", "displacement", "m", STEP_M, 0.0, RATE),
    ChannelDescription("a", "acceleration", "m/s^2", 1e-3, 0.0, RATE),
)
LOW, HIGH = -0.005, 0.025
FREE, MOVING, HELD, LETTING_GO = list(HolderState)[:4]


class Rig:
    """A board with a noiseless mass in its holder, and a host that says something every 0.2 s unless it is `mute`."""

    def __init__(
        self, low: float = LOW, high: float = HIGH, has_holder: bool = True, speed: float = 1.0
    ) -> None:
        self.now, self.mute, self.sequence = 50.0, False, 0
        self.physics, self.said = Physics(), []
        self.actuator = Actuator(self.physics, low, high) if has_holder else None
        self.decoder = Decoder()
        random = np.random.default_rng(3)
        self.board = Board(CHANNELS, self.source, random, self.now, speed, holder=self.actuator)

    def source(self, rate: float) -> Acquisition:
        return Acquisition(
            self.physics,
            self.actuator.capture(),
            rate,
            (Sensor(), Sensor()),
            (Converter(STEP_M, 0.0), Converter(1e-3, 0.0)),
            {},
            np.random.default_rng(4),
            lambda chunk, sample: None,
            Misconfiguration().late_s,
        )

    def send(self, message, sequence=None):
        """Send one message and return what the board answers at once."""
        if sequence is None:
            sequence, self.sequence = self.sequence, self.sequence + 1
        before = len(self.said)
        self.board.receive(encode(message, sequence), self.now)
        self.listen()
        return self.said[before:]

    def listen(self) -> None:
        for data in self.board.poll(self.now, True):
            self.said += [frame.message for frame in self.decoder.feed(data)]

    def wait(self, seconds: float) -> None:
        for step in range(round(seconds / 0.01)):
            self.now += 0.01
            self.listen()
            if step % 20 == 0 and not self.mute:
                self.send(TimeSync(step + 1))

    def last(self, kind):
        return next(message for message in reversed(self.said) if isinstance(message, kind))

    def asked(self) -> Holder:
        self.send(HelloRequest())
        return self.last(Holder)

    def ask(self, message):
        """Send a request and return its ACK or NACK."""
        return next(m for m in self.send(message) if isinstance(m, Ack | Nack))

    def hold(self, displacement: float) -> Ack | Nack:
        return self.ask(Hold(self.asked().ticket, displacement))

    def held(self, displacement: float = 0.012) -> Holder:
        assert isinstance(self.hold(displacement), Ack)
        self.wait(3.0)
        assert self.last(Holder).state is HELD
        return self.last(Holder)

    def place(self) -> float:
        """The newest displacement that was sampled, m."""
        data = self.last(Data)
        return float(np.frombuffer(data.samples, "<i2")[-2]) * STEP_M

    def samples(self) -> np.ndarray:
        """All displacements of the last capture, m."""
        parts = [np.frombuffer(m.samples, "<i2")[::2] for m in self.said if isinstance(m, Data)]
        return np.concatenate(parts) * STEP_M


def test_a_board_with_a_holder_says_so_behind_its_description():
    report = Rig().asked()
    assert (report.low, report.high, report.silence_s) == (LOW, HIGH, SILENCE_S)
    assert (report.state, report.reason, report.sample) == (FREE, HolderReason.BOOT, NO_SAMPLE)


def test_a_board_without_one_understands_nothing_of_it_and_never_speaks_of_it():
    rig = Rig(has_holder=False)
    for request in (Hold(0, 0.01), Release(0)):
        assert rig.ask(request).code is NackCode.NOT_UNDERSTOOD
    rig.send(HelloRequest())
    assert not [m for m in rig.said if isinstance(m, Holder)]


def test_the_mass_is_taken_held_and_let_go_at_the_sample_that_is_told():
    rig = Rig()
    rig.send(Start())
    report = rig.held(0.012)
    assert (report.displacement, report.reason) == (0.012, HolderReason.REQUEST)
    assert rig.place() == pytest.approx(0.012, abs=STEP_M)
    assert isinstance(rig.ask(Release(report.ticket)), Ack)
    freed = rig.last(Holder)
    assert (freed.state, freed.displacement) == (FREE, 0.0)
    rig.wait(4.0)
    x, first = rig.samples(), freed.sample
    assert x[first - 200 : first] == pytest.approx(0.012, abs=STEP_M)
    time = np.arange(0, len(x) - first) / RATE
    # The release lies within the sample before the one told, and takes the magnet's time.
    late = rig.actuator.released_at - rig.actuator.origin
    motion = simulate(rig.physics, BoardError(0.012, 0.0, MAGNET_S), first / RATE - late + time)
    assert x[first:] == pytest.approx(motion.displacement, abs=1.5 * STEP_M)


@pytest.mark.parametrize("wrong", [0.026, -0.006, 1e300, math.inf, math.nan])
def test_a_displacement_beyond_the_limits_is_refused_by_the_board_and_nothing_moves(wrong):
    rig = Rig()
    rig.send(Start())
    answer = rig.hold(wrong)
    assert answer.code is NackCode.LIMIT
    assert "-5 to 25 mm" in answer.text
    rig.wait(2.0)
    assert not rig.samples().any()


def test_a_release_without_a_hold_is_refused():
    rig = Rig()
    assert rig.ask(Release(rig.asked().ticket)).code is NackCode.NOTHING_HELD


def test_a_release_on_the_way_is_refused():
    rig = Rig()
    rig.hold(0.012)
    assert rig.ask(Release(rig.last(Holder).ticket)).code is NackCode.NOTHING_HELD


def test_a_ticket_serves_once_and_a_lost_answer_does_no_harm():
    rig = Rig()
    hold = Hold(rig.asked().ticket, 0.012)
    assert isinstance(rig.ask(hold), Ack)
    assert isinstance(rig.ask(hold), Ack)  # its first ACK was lost
    assert rig.ask(Hold(hold.ticket, 0.013)).code is NackCode.STALE
    rig.wait(3.0)
    release = Release(rig.last(Holder).ticket)
    assert isinstance(rig.ask(release), Ack)
    assert isinstance(rig.ask(release), Ack)
    rig.wait(14.0)
    assert rig.ask(hold).code is NackCode.STALE
    assert rig.last(Holder).state is FREE


def test_after_a_reset_no_earlier_frame_moves_anything():
    rig = Rig()
    hold = Hold(rig.asked().ticket, 0.012)
    rig.ask(hold)
    rig.wait(3.0)
    release = Release(rig.last(Holder).ticket)
    rig.board.reboot(rig.now)
    rig.decoder = Decoder()
    assert rig.ask(release).code is NackCode.NOTHING_HELD
    assert rig.ask(hold).code is NackCode.STALE
    assert rig.last(Holder).reason is HolderReason.REQUEST  # nothing was said since
    assert rig.asked().reason is HolderReason.BOOT
    assert rig.last(Holder).state is FREE


def test_stop_lets_go_slowly_at_any_time():
    for seconds in (0.1, 3.0):  # on the way, and held
        rig = Rig()
        rig.send(Start())
        rig.hold(0.012)
        rig.wait(seconds)
        rig.send(Stop())
        assert (rig.last(Holder).state, rig.last(Holder).reason) == (LETTING_GO, HolderReason.STOP)
        assert rig.hold(0.01).code is NackCode.BUSY
        rig.wait(6.0)
        assert rig.last(Holder).state is FREE
        rig.said.clear()
        rig.send(Start())
        rig.wait(1.0)
        assert not rig.samples().any()


def slowly(x: np.ndarray) -> bool:
    """Whether the mass was taken back to 0, never faster than is allowed, and never swung."""
    fastest = -np.diff(x).min() * RATE
    return x.min() >= -STEP_M and abs(x[-1]) < STEP_M and fastest < SLOWLY_M_S + STEP_M * RATE


@pytest.mark.parametrize("seconds", [0.3, 3.0])
def test_a_host_that_falls_silent_makes_the_board_hold_and_then_let_go_slowly(seconds):
    rig = Rig()
    rig.send(Start())
    rig.hold(0.012)
    rig.wait(seconds)
    rig.mute = True
    rig.wait(SILENCE_S - 0.25)
    assert rig.last(Holder).state in (MOVING, HELD)
    ticket = rig.last(Holder).ticket
    rig.wait(6.0)
    assert (rig.last(Holder).state, rig.last(Holder).reason) == (FREE, HolderReason.SILENCE)
    assert slowly(rig.samples())
    assert rig.ask(Release(ticket)).code is NackCode.NOTHING_HELD
    assert rig.ask(Hold(ticket, 0.01)).code is NackCode.STALE


def test_a_line_that_echoes_or_repeats_is_no_host():
    rig = Rig()
    rig.held()
    rig.mute = True
    for _ in range(40):
        rig.send(TimeSync(5, 77))  # the board's own answer, given back
        rig.send(TimeSync(5), sequence=9999)  # one frame, again and again
        rig.wait(0.1)
    assert rig.last(Holder).reason is HolderReason.SILENCE


def test_a_line_that_is_closed_makes_the_board_let_go_slowly_at_once():
    rig = Rig()
    rig.held()
    rig.board.hang_up(rig.now)
    rig.wait(0.1)
    assert (rig.last(Holder).state, rig.last(Holder).reason) == (LETTING_GO, HolderReason.SILENCE)


def test_a_stop_contact_that_opens_lets_go_slowly_and_keeps_the_holder_from_moving():
    rig = Rig()
    rig.held()
    rig.board.contact(True, rig.now)
    rig.wait(5.0)
    assert (rig.last(Holder).state, rig.last(Holder).reason) == (FREE, HolderReason.CONTACT)
    assert rig.hold(0.01).code is NackCode.HOLDER
    rig.board.contact(False, rig.now)
    assert isinstance(rig.hold(0.01), Ack)


def test_a_mass_that_still_swings_is_taken_once_it_rests():
    rig = Rig()
    rig.send(Start())
    rig.ask(Release(rig.held().ticket))
    rig.wait(1.0)
    rig.hold(0.02)
    rig.wait(2.0)
    assert rig.last(Holder).state is MOVING
    assert np.ptp(rig.samples()[-256:]) > 0.005
    rig.wait(14.0)
    assert rig.last(Holder).state is HELD
    assert rig.place() == pytest.approx(0.02, abs=STEP_M)


ANYTHING = st.one_of(
    st.builds(Hold, st.sampled_from([0, 1, 2]), st.sampled_from([0.0, 0.012, 0.05, math.nan])),
    st.builds(Release, st.sampled_from([0, 1, 2])),
    st.sampled_from([Start(), Stop(), HelloRequest(), TimeSync(1)]),
    st.sampled_from([0.3, 3.0]),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(ANYTHING, max_size=12))
def test_frames_in_any_order_with_any_old_ticket_move_nothing(words):
    rig = Rig()
    rig.send(Start())
    used = [rig.asked().ticket + 1, 0, 0xFFFFFFFF]
    for word in words:
        if isinstance(word, float):
            rig.wait(word)
        elif isinstance(word, Hold | Release):
            assert isinstance(rig.ask(replace(word, ticket=used[word.ticket])), Nack)
        else:
            rig.send(word)
    rig.send(Stop())
    rig.send(Start())
    rig.wait(0.5)
    assert not rig.samples().any()
    assert rig.asked().state is FREE


FRESH = st.sampled_from(["hold", "hold elsewhere", "release", "stop", "mute", "hang up", "reset", 0.1, 3.0])


@settings(max_examples=60, deadline=None)
@given(st.lists(FRESH, max_size=12))
def test_fresh_commands_in_any_order_let_go_at_once_only_by_an_accepted_release(words):
    rig = Rig()
    rig.send(Start())
    for word in words:
        ticket, state = rig.asked().ticket, rig.last(Holder).state
        if isinstance(word, float):
            rig.wait(word)
        elif word.startswith("hold"):
            accepted = isinstance(rig.ask(Hold(ticket, 0.012 if word == "hold" else -0.004)), Ack)
            assert accepted == (state in (FREE, HELD))
        elif word == "release":
            accepted = isinstance(rig.ask(Release(ticket)), Ack)
            assert accepted == (state is HELD)
            if accepted:
                return
        elif word == "stop":
            rig.send(Stop())
            rig.send(Start())
        elif word == "hang up":
            rig.board.hang_up(rig.now)
        elif word == "reset" and state is FREE:
            rig.board.reboot(rig.now)
            rig.decoder = Decoder()
            rig.send(Start())
        elif word == "mute":
            rig.mute = not rig.mute
    rig.wait(0.5)
    x = rig.samples()
    assert -0.004 - STEP_M <= x.min() <= x.max() <= 0.012 + STEP_M
    # 20 mm/s and one step of the converter a sample; a swing from 4 mm would reach 95 mm/s.
    assert np.abs(np.diff(x)).max() * RATE < 0.020 + STEP_M * RATE


def test_tickets_do_not_come_again():
    rig, seen = Rig(), set()
    for _ in range(30):
        report = rig.asked()
        assert report.ticket not in seen
        seen.add(report.ticket)
        rig.hold(0.001)
        rig.wait(1.0)
        assert rig.last(Holder).ticket not in seen
        rig.send(Stop())
        rig.wait(1.5)
