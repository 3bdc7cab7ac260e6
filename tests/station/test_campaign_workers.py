"""Workers that are real processes: all sessions are answered, whoever is killed in the middle."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from many_sessions import deadly, slowly, work_called

from station.campaign.run import KILLED, performed

HERE = str(Path(__file__).parent)


def names(count):
    return [f"session {i}" for i in range(count)]


def test_without_workers_this_process_does_the_work():
    works = [work_called(name) for name in names(2)]
    found = list(performed(iter(works), 0, slowly))
    assert [(work, answer.session) for work, answer in found] == list(zip(works, names(2), strict=True))


@pytest.mark.slow
def test_a_process_that_is_killed_loses_nothing_and_the_session_that_kills_it_costs_no_other(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([HERE, *sys.path]))
    works = [work_called(name) for name in (*names(8), "deadly", "faulty")]
    found = []
    for work, answer in performed(works, 2, deadly):
        found.append((work.folder.name, answer))
        if len(found) == 3:
            multiprocessing.active_children()[0].kill()
    assert Counter(name for name, _ in found) == Counter([*names(8), "deadly", "faulty"])
    told = dict(found)
    assert told.pop("deadly") == KILLED
    assert "ZeroDivisionError: division by zero" in told.pop("faulty")
    assert {name: answer.session for name, answer in told.items()} == {name: name for name in names(8)}


ORPHANS = """
import multiprocessing, os, signal
from many_sessions import slowly, work_called
from station.campaign.run import performed
if __name__ == "__main__":
    answers = performed([work_called("first"), work_called("second")], 1, slowly)
    next(answers)
    print(multiprocessing.active_children()[0].pid, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.slow
def test_no_process_outlives_a_program_that_is_killed(tmp_path):
    script = tmp_path / "orphans.py"
    script.write_text(ORPHANS)
    path = os.pathsep.join([HERE, *sys.path])
    ended = subprocess.run(
        [sys.executable, str(script)], env=os.environ | {"PYTHONPATH": path}, capture_output=True, check=False
    )
    pid = int(ended.stdout)
    for _ in range(200):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    os.kill(pid, signal.SIGKILL)
    pytest.fail("the worker is still there")
