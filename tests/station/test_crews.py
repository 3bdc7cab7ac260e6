"""Crews of real processes: all sessions are answered, whoever is killed in the middle."""

import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from many_sessions import deadly, make_sessions, slowly, work_called

from station.campaign.dask_crew import MISSING, DaskCrew
from station.campaign.local_crew import KILLED, LocalCrew
from station.cli import run as station
from station.exits import UsageProblem

HERE = str(Path(__file__).parent)


def names(count):
    return [f"session {i}" for i in range(count)]


def test_a_missing_package_is_one_sentence_with_the_line_to_type(monkeypatch, tmp_path, capsys):
    make_sessions(tmp_path / "sessions", 1, seconds=1.5)
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert station(["campaign", str(tmp_path / "sessions"), "--scheduler", "tcp://127.0.0.1:1"]) == 2
    assert MISSING in capsys.readouterr().err
    assert "pip install" in MISSING


@pytest.mark.slow
def test_a_process_that_is_killed_loses_nothing(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([HERE, *sys.path]))
    works = [work_called(name) for name in names(12)]
    found = []
    for answer in LocalCrew(2, slowly).performed(works):
        found.append(answer)
        if len(found) == 3:
            multiprocessing.active_children()[0].kill()
    assert Counter(answer.result for answer in found) == Counter(names(12))
    assert all(not answer.problem for answer in found)


@pytest.mark.slow
def test_the_session_that_kills_its_worker_fails_and_costs_no_other(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([HERE, *sys.path]))
    works = [work_called(name) for name in (*names(3), "deadly", "faulty", *names(6)[3:])]
    found = {answer.work.name: answer for answer in LocalCrew(2, deadly).performed(works)}
    assert found.pop("deadly").problem == KILLED
    assert found.pop("faulty").problem == "ZeroDivisionError: division by zero"
    assert {name: answer.result for name, answer in found.items()} == {name: name for name in names(6)}


ORPHANS = """
import multiprocessing, os, signal
from many_sessions import slowly, work_called
from station.campaign.local_crew import LocalCrew
if __name__ == "__main__":
    next(LocalCrew(1, slowly).performed([work_called("first")]))
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


@pytest.fixture
def cluster(monkeypatch):
    """A scheduler and two workers, each a process of its own that knows where the tests are."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([HERE, *sys.path]))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        yield cluster


def processes(cluster):
    return [worker.pid for worker in cluster.workers.values()]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # the cluster's own, on closing
def test_a_worker_of_a_cluster_that_is_killed_loses_nothing(cluster):
    works = [work_called(name) for name in names(12)]
    found = []
    crew = DaskCrew(cluster.scheduler_address, slowly)
    for answer in crew.performed(works):
        found.append(answer)
        if len(found) == 3:
            assert crew.workers == 2
            os.kill(processes(cluster)[0], signal.SIGKILL)
    assert Counter(answer.result for answer in found) == Counter(names(12))
    assert all(not answer.problem for answer in found)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_sessions_go_to_a_cluster_with_their_content_and_the_results_come_home(cluster, tmp_path, capsys):
    folder = make_sessions(tmp_path / "sessions", 4)
    assert station(["campaign", str(folder), "--scheduler", cluster.scheduler_address]) == 0
    assert "4 sessions identified" in capsys.readouterr().out
    assert len(list((folder / "campaign" / "sessions").iterdir())) == 4


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_without_a_worker_left_is_one_sentence(cluster):
    cluster.scale(0)
    crew = DaskCrew(cluster.scheduler_address, slowly, patience=1.0)
    with pytest.raises(UsageProblem, match=r"no worker is left at .*finished sessions are kept"):
        list(crew.performed([work_called("alone")]))


@pytest.mark.slow
def test_nobody_at_the_address_is_one_sentence(monkeypatch):
    monkeypatch.setattr("station.campaign.dask_crew.CONNECT_S", 0.5)
    with pytest.raises(UsageProblem, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        list(DaskCrew("tcp://127.0.0.1:9").performed([]))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_goes_in_the_middle_is_one_sentence(cluster):
    works = [work_called(name) for name in names(12)]
    answers = DaskCrew(cluster.scheduler_address, slowly).performed(works)
    next(answers)
    with contextlib.suppress(Exception):
        cluster.close(timeout=5)
    with pytest.raises(UsageProblem, match=r"the scheduler at .* is gone"):
        list(answers)
