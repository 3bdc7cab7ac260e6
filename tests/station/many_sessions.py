"""A folder of simulated sessions of one bench, and workers that need no process: what the tests of campaigns share."""

import os
import signal
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from daq.recording import Channel, Recording
from daq.session import Session
from daq.session_info import SessionInfo
from mocks.generate import draw
from station.campaign.work import Work, perform
from station.results.campaign_document import SessionResult

CHANNELS = (Channel("displacement", "displacement", "m"), Channel("acceleration", "acceleration", "m/s^2"))
BEGAN = datetime(2026, 3, 1, tzinfo=UTC)
STIFFNESS, SOFTER_PER_DEGREE = 613.6, -2e-3


def make_sessions(folder, count, *, seconds=3.0):
    """Make sessions an hour apart; the spring gets softer with the temperature, from 20 degC on."""
    random = np.random.default_rng(4)
    for i in range(count):
        temperature = round(20.0 + 5.0 * random.random(), 2)
        stiffness = STIFFNESS * (1.0 + SOFTER_PER_DEGREE * (temperature - 20.0))
        sample = draw(None, 0.0, i, stiffness=stiffness, mu_0=0.1, mu_1=0.25, amplitude=0.02, seconds=seconds)
        info = SessionInfo(created=BEGAN + timedelta(hours=i), conditions={"temperature [degC]": temperature})
        make_session(
            folder / f"r{i:03d}", sample.rate, np.array([sample.displacement, sample.acceleration]), info
        )
    return folder


def make_session(folder, rate, readings, info=None):
    recording = Recording(rate, CHANNELS, readings, np.ones(readings.shape[1], dtype=bool))
    return Session.create_imported(folder, recording, None, info)


def make_noise(folder):
    """Make a session in which nothing is released."""
    readings = 1e-5 * np.random.default_rng(1).standard_normal((2, 600))
    return make_session(folder, 256.0, readings, SessionInfo(created=BEGAN))


class Here:
    """What stands for the workers, in this process; `after` sessions the operator presses Ctrl-C."""

    def __init__(self, after=None):
        self.performed_names, self.after = [], after

    def __call__(self, works, workers):
        for work in works:
            if self.after is not None and len(self.performed_names) >= self.after:
                raise KeyboardInterrupt
            self.performed_names.append(work.folder.name)
            yield work, perform(work)


def work_called(name):
    from station.story.preparation import Options

    return Work(Path(name), name, Options())


def _result(work):
    return SessionResult(format=1, session=work.folder.name, key=work.key, seconds=0.0)


def slowly(work):
    """Take a moment, so that a worker can be killed in the middle."""
    time.sleep(0.3)
    return _result(work)


def deadly(work):
    """Kill the worker that gets the session called "deadly"; fail at the one called "faulty", else take a moment."""
    if work.folder.name == "deadly":
        os.kill(os.getpid(), signal.SIGKILL)
    if work.folder.name == "faulty":
        raise ZeroDivisionError("division by zero")
    return slowly(work)
