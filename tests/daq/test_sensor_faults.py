"""Sensors that fail during the record, made of a closed form: what is found, where, and what is left alone."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from daq.quality import Grade, judge
from daq.reading_flags import Flag
from daq.recording import Channel, Recording
from daq.sensor_faults import MOST_RUNS, sensor_faults
from daq.session import Session, verify
from station.cli import run

RATE, OMEGA, LOSS = 256.0, 24.78, 0.33
SIZE = {"displacement": 0.02, "acceleration": 12.0, "velocity": 0.5}
UNIT = {"displacement": "m", "acceleration": "m/s^2", "velocity": "m/s"}
NOISE, CODE = 3e-4, 5e-5
RELEASE, STRUCK, COUNT = 192, 640, 2240  # samples; struck at 2.5 s

Change = Callable[[np.ndarray], np.ndarray]


def channel(quantity: str, seed: int = 1) -> np.ndarray:
    """A viscous free decay from rest, held until RELEASE, with noise and the steps of a converter."""
    random = np.random.default_rng([seed, len(quantity)])
    time = (np.arange(COUNT) - RELEASE) / RATE
    free = time > 0.0
    phase = {"displacement": 0.0, "velocity": np.pi / 2, "acceleration": np.pi}[quantity]
    held = 1.0 if quantity == "displacement" else 0.0
    x = np.where(free, np.exp(-LOSS * np.maximum(time, 0.0)) * np.cos(OMEGA * time + phase), held)
    x = np.rint((x + NOISE * random.standard_normal(COUNT)) / CODE) * CODE
    return SIZE[quantity] * x


def record(*quantities: str, broken: dict[str, Change] | None = None, unit: str = "") -> Recording:
    broken = broken or {}
    samples = [broken.get(q, lambda x: x)(channel(q)) for q in quantities]
    channels = tuple(Channel(q, q, unit or UNIT[q]) for q in quantities)
    return Recording(RATE, channels, np.array(samples), np.ones(COUNT, dtype=bool), trigger=RELEASE)


def stuck(x: np.ndarray, seconds: float = 0.5) -> np.ndarray:
    x = x.copy()
    x[STRUCK : STRUCK + round(seconds * RATE)] = x[STRUCK]
    return x


def repeats(x: np.ndarray, every: int = 5) -> np.ndarray:
    x = x.copy()
    x[every::every] = x[every - 1 : -1 : every][: len(x[every::every])]
    return x


def gain(x: np.ndarray, factor: float = 0.5) -> np.ndarray:
    return np.where(np.arange(len(x)) < STRUCK, x, factor * x)


def sign(x: np.ndarray) -> np.ndarray:
    return gain(x, -1.0)


def flat(x: np.ndarray, share: float = 0.6) -> np.ndarray:
    top = share * np.abs(x).max()
    return np.clip(x, -top, top)


def wraps(x: np.ndarray) -> np.ndarray:
    half = 0.6 * np.abs(x).max()
    return (x + half) % (2 * half) - half


def spikes(x: np.ndarray) -> np.ndarray:
    x = x.copy()
    x[[500, 640, 641, 803]] += 0.5 * np.abs(x).max()
    return x


FAULTS = {
    Flag.STUCK: (stuck, "is stuck while the mass moves, for 0.496 s from 2.504 s on"),
    Flag.REPEATED: (repeats, "repeats the reading before it in"),
    Flag.GAIN: (gain, "changes by a factor of 0.5"),
    Flag.SIGN: (sign, "changes its sign at about 2."),
    Flag.SATURATED: (flat, "is cut off flat in"),
    Flag.WRAPPED: (wraps, "wraps round from one end of its range to the other in"),
    Flag.SPIKE: (spikes, "leaps away from its neighbours in 4 samples, first at 1.953 s"),
}
SETS = [("displacement",), ("acceleration",), ("velocity",), ("displacement", "acceleration")]


@pytest.mark.parametrize("quantities", SETS, ids="+".join)
def test_a_sound_record_is_ok_and_has_no_flag(quantities: tuple[str, ...]) -> None:
    assert sensor_faults(record(*quantities)).runs == ()
    assert judge(record(*quantities)).grade is Grade.OK


@pytest.mark.parametrize("flag", FAULTS)
@pytest.mark.parametrize("quantities", SETS, ids="+".join)
@pytest.mark.parametrize("which", ["one", "all"])
def test_a_fault_during_the_record_is_named_with_its_place(
    flag: Flag, quantities: tuple[str, ...], which: str
) -> None:
    change, words = FAULTS[flag]
    at_fault = quantities[:1] if which == "one" else quantities
    found = record(*quantities, broken=dict.fromkeys(at_fault, change))
    verdict = judge(found)
    assert verdict.grade is (Grade.USABLE if flag is Flag.SPIKE else Grade.REJECT)
    for name in at_fault:
        assert any(name in reason and words in reason for reason in verdict.reasons), verdict
    if flag in (Flag.SIGN, Flag.GAIN):  # a quarter of a period is as near as a cycle tells
        seconds = [
            float(reason.split("about ")[1].split(" s")[0])
            for reason in verdict.reasons
            if "about " in reason
        ]
        assert seconds == pytest.approx([STRUCK / RATE] * len(at_fault), abs=np.pi / 2 / OMEGA)
    assert any(at_fault[0] in advice for advice in verdict.advice)
    assert {one.channel for one in sensor_faults(found).runs if one.flag is flag} == set(at_fault)


def test_an_imported_session_keeps_its_flags_and_tells_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sound = Session.create_imported(tmp_path / "sound", record("displacement"), None)
    assert b'"flags"' not in (sound.folder / "manifest.json").read_bytes()
    broken = record("displacement", broken={"displacement": stuck})
    session = Session.create_imported(tmp_path / "broken", broken, None)
    assert judge(broken).grade is Grade.REJECT
    assert session.verdict == judge(broken)
    (kept,) = Session.open(session.folder).manifest().flags
    assert (kept.channel, kept.flag, kept.first, kept.count) == ("displacement", "stuck", 641, 127)
    assert verify(session.folder).ok
    assert run(["info", str(session.folder)]) == 0
    assert "displacement: stuck, 127 samples from 2.504 to 3.000 s" in " ".join(
        capsys.readouterr().out.split()
    )


def test_a_rotation_is_looked_at_as_a_displacement_is() -> None:
    angle = record("displacement", broken={"displacement": stuck}, unit="rad")
    assert judge(angle).grade is Grade.REJECT


def test_the_flags_are_the_samples_at_fault() -> None:
    held = sensor_faults(record("displacement", broken={"displacement": stuck})).runs
    assert [(one.first, one.count) for one in held] == [(STRUCK + 1, round(0.5 * RATE) - 1)]
    leaps = sensor_faults(record("displacement", broken={"displacement": spikes})).runs
    assert [(one.first, one.count) for one in leaps] == [(500, 1), (640, 2), (803, 1)]


def test_a_channel_that_dies_while_the_other_goes_on_is_stuck_to_the_end() -> None:
    dead = record("displacement", "acceleration", broken={"displacement": lambda x: stuck(x, 60.0)})
    assert any("displacement is stuck" in reason for reason in judge(dead).reasons)


def test_a_mass_that_comes_to_rest_is_not_stuck() -> None:
    """Dry friction stops it for good between two samples, and both sensors repeat their readings."""
    time = (np.arange(COUNT) - RELEASE) / RATE
    half = np.maximum(np.floor(OMEGA * time / np.pi), 0)
    swings = 9
    size = np.maximum(1.0 - (2 * half + 1) / (2 * swings), 0.0)
    middle = np.where(half % 2 == 0, 1, -1) / (2 * swings)
    x = np.where(time > 0, size * np.cos(OMEGA * time) + middle * (size > 0), 1.0)
    x = np.where(half >= swings, x[half < swings][-1], x)
    found = Recording(
        RATE, (Channel("x", "displacement", "m"),), x[None], np.ones(COUNT, dtype=bool), trigger=RELEASE
    )
    assert sensor_faults(found).runs == ()


def test_steps_of_a_coarse_converter_are_not_repeated_readings() -> None:
    coarse = record(
        "displacement", "acceleration", broken=dict.fromkeys(SIZE, lambda x: np.rint(x / np.ptp(x) * 100))
    )
    assert sensor_faults(coarse).runs == ()


def test_blows_against_a_stop_are_not_spikes() -> None:
    """Short pulses of acceleration at each turning point of one side."""
    time = (np.arange(COUNT) - RELEASE) / RATE
    turn = (
        np.exp(-(((time * OMEGA / (2 * np.pi) + 0.5) % 1.0 - 0.5) ** 2) / (2 * 0.01**2))
        * (time > 0.1)
        * (time < 2)
    )
    blown = record("acceleration", broken={"acceleration": lambda x: x - 6.0 * turn})
    assert sensor_faults(blown).suspicions == ()


def test_a_second_push_changes_both_channels_and_is_no_fault() -> None:
    pushed = {name: lambda x: np.where(np.arange(COUNT) < STRUCK, x, 1.6 * np.roll(x, 20)) for name in SIZE}
    found = sensor_faults(record("displacement", "acceleration", broken=pushed))
    assert not [one for one in found.runs if one.flag in (Flag.GAIN, Flag.SIGN)]


@pytest.mark.parametrize(("readings", "noise"), [(8, 1e-4), (12, 1e-3)])
def test_readings_that_repeat_too_often_are_told_where_a_cycle_has_few(readings: int, noise: float) -> None:
    time = np.arange(60 * readings) / readings
    x = np.exp(-time / 20.0) * np.cos(2.0 * np.pi * time)
    x = repeats(x + noise * np.random.default_rng(3).standard_normal(len(x)), 3)
    channels = (Channel("x", "displacement", "m"),)
    found = sensor_faults(Recording(RATE, channels, x[None], np.ones(len(x), dtype=bool)))
    assert any("repeats the reading before it" in suspicion.reason for suspicion in found.suspicions)


def test_a_few_repeated_readings_leave_the_record_usable() -> None:
    def change(x: np.ndarray) -> np.ndarray:
        x = x.copy()
        for at in (400, 480, 561, 643):
            x[at : at + 4] = x[at]
        return x

    verdict = judge(record("displacement", broken={"displacement": change}))
    assert verdict.grade is Grade.USABLE
    assert "repeats the reading before it in 12 samples" in verdict.reasons[0]


def test_a_driven_motion_that_grows_is_no_change_of_gain() -> None:
    force = Channel("f", "force", "N")
    found = record("displacement", broken={"displacement": gain})
    driven = replace(
        found, channels=(*found.channels, force), samples=np.vstack([found.samples, found.samples])
    )
    assert not [one for one in sensor_faults(driven).runs if one.flag is Flag.GAIN]


def test_numbers_that_are_none_are_no_fault_and_no_warning() -> None:
    wild = record(
        "displacement", broken={"displacement": lambda x: np.where(np.arange(COUNT) % 7, x, np.inf)}
    )
    assert sensor_faults(wild).suspicions == ()
    assert sensor_faults(replace(wild, samples=np.full((1, COUNT), 1e308))).runs == ()
    assert (
        sensor_faults(replace(wild, samples=wild.samples[:, :9], valid=wild.valid[:9], trigger=None)).runs
        == ()
    )


def test_very_many_runs_are_joined_where_they_are_closest() -> None:
    long = np.tile(channel("displacement")[RELEASE : RELEASE + 254], 60)
    every = Recording(
        RATE, (Channel("x", "displacement", "m"),), repeats(long)[None], np.ones(len(long), dtype=bool)
    )
    runs = [one for one in sensor_faults(every).runs if one.flag is Flag.REPEATED]
    assert len(runs) == MOST_RUNS
    assert runs[-1].first + runs[-1].count > 0.95 * len(long)
