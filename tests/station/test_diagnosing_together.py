"""Several sessions to diagnose: what was changed on purpose is declared, and another bench is refused."""

import re

import numpy as np
import pytest
from many_sessions import make_session

from daq.session_info import SessionInfo
from mocks.generate import draw
from station.cli import run as station
from station.exits import UsageProblem
from station.operations.diagnosing import check_same_bench, diagnose_sessions
from station.operations.session_set import by_reason, open_sessions
from station.settings import Settings

pytestmark = pytest.mark.usefixtures("among_few")
STIFFNESS = 613.6


@pytest.fixture(scope="module")
def sessions(tmp_path_factory):
    """Sessions of one bench ("a", "b"), of a softer spring ("soft") and of quite another ("stiff"); "a" is the largest."""
    folder = tmp_path_factory.mktemp("together")
    benches = {"a": 1.0, "b": 1.0, "soft": 0.969, "stiff": 3.0}
    for seed, (name, factor) in enumerate(benches.items()):
        rig = {"stiffness": factor * STIFFNESS, "mu_0": 0.13, "mu_1": 0.29, "seconds": 3.0}
        made = draw(None, 0.0, seed, amplitude=0.025 if name == "a" else 0.02, **rig)
        make_session(folder / name, made.rate, np.array([made.displacement, made.acceleration]))
    return folder


def opened(folder, *names):
    return open_sessions(tuple(str(folder / name) for name in names), Settings())


def test_the_largest_release_comes_first_in_whatever_order_they_are_given(sessions):
    assert opened(sessions, "soft", "a").names == opened(sessions, "a", "soft").names == ("a", "soft")


def test_what_was_changed_on_purpose_is_declared_and_each_session_has_its_own(sessions):
    said = []
    both = open_sessions(
        tuple(str(sessions / name) for name in ("a", "stiff")), Settings(), frozenset({"stiffness"})
    )
    check_same_bench(both, False, said.append)
    assert said == ["stiffness: each session has its own, as declared"]
    found, document = diagnose_sessions(both)
    assert found.verdict == "nothing_missing"
    assert document.varies == ["stiffness"]
    springs = [one.value.value for one in document.of_sessions if one.parameter == "linear_stiffness.k"]
    assert springs == pytest.approx([STIFFNESS, 3.0 * STIFFNESS], rel=1e-3)


def test_what_a_session_says_of_itself_need_not_be_said_again(sessions, tmp_path):
    rig = {"stiffness": 3.0 * STIFFNESS, "mu_0": 0.13, "mu_1": 0.29, "seconds": 3.0}
    made = draw(None, 0.0, 7, amplitude=0.02, **rig)
    make_session(
        tmp_path / "other",
        made.rate,
        np.array([made.displacement, made.acceleration]),
        SessionInfo(varies=("stiffness",)),
    )
    names = (str(sessions / "a"), str(tmp_path / "other"))
    assert open_sessions(names, Settings()).varies == {"stiffness"}


def test_what_cannot_vary_is_refused_with_what_can(sessions, capsys):
    names = [str(sessions / name) for name in ("a", "stiff")]
    assert station(["diagnose", *names, "--varies", "stifness", "--no-viewer"]) == 2
    assert "did you mean 'stiffness'" in capsys.readouterr().err


def test_a_session_that_holds_too_little_is_left_out_and_the_others_are_diagnosed(sessions, tmp_path):
    made = draw(None, 0.0, 7, amplitude=0.02, stiffness=STIFFNESS, mu_0=0.13, mu_1=0.29)
    kept = slice(round((0.8 + 0.2) * made.rate))
    make_session(tmp_path / "short", made.rate, np.array([made.displacement, made.acceleration])[:, kept])
    left = open_sessions((str(sessions / "a"), str(tmp_path / "short"), str(sessions / "b")), Settings())
    assert left.names == ("a", "b")
    assert list(left.left_out) == ["short"]


def test_another_bench_is_refused_with_what_to_do_unless_anyway(sessions, capsys):
    assert station(["diagnose", str(sessions / "a"), str(sessions / "stiff"), "--no-viewer"]) == 2
    said = capsys.readouterr().err
    assert "stiff: another bench than a" in said
    found, first = (float(text) for text in re.search(r"motion, (\S+) against (\S+) 1/s²", said).groups())
    assert found > 1.3 * first
    both = opened(sessions, "a", "stiff")
    with pytest.raises(UsageProblem, match="--anyway"):
        check_same_bench(both, False, lambda text: None)
    check_same_bench(both, True, lambda text: None)


def test_a_reason_that_many_sessions_share_is_said_once():
    assert by_reason({"a": "too short", "b": "no release", "c": "too short"}) == [
        "a, c: too short",
        "b: no release",
    ]
