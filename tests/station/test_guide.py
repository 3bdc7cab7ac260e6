import json
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from daq.capture import CaptureObserver, CaptureSettings
from daq.quality import Grade, Verdict
from daq.recording import Channel
from identify.diagnosis.guidance import first_release
from station.cli import run
from station.exits import UsageProblem
from station.operations import guiding
from station.operations.guiding import SMALLER, GuidedTest, _again, guide, limits_of
from station.operations.provisional import Provisional
from station.results.diagnosis_document import HypothesisDocument
from station.results.guide_document import TurnDocument
from station.settings import Settings
from station.text.guide_text import gave, odds_chart, percent
from tests.identify.specimens import diagnosed


def test_limits_are_two_lengths_with_their_units():
    limits = limits_of("2mm, 2.5 cm")
    assert (limits.low, limits.high) == pytest.approx((0.002, 0.025))


@pytest.mark.parametrize("wrong", ["2,25", "2mm", "25mm,2mm", "0mm,3mm", "2mm,3kg", "-2mm,3mm", "a,b", ""])
def test_limits_that_are_none_are_refused_in_words(wrong):
    with pytest.raises(UsageProblem, match="2mm,25mm"):
        limits_of(wrong)


def test_an_unattended_rig_is_not_asked_to_push():
    assert "push" in limits_of("2mm,25mm").ways
    assert "push" not in limits_of("2mm,25mm", unattended=True).ways


def test_without_a_terminal_the_limits_must_be_given(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["guide", "--port", "socket://127.0.0.1:9"]) == 2
    assert "--limits 2mm,25mm" in capsys.readouterr().err


def test_odds_that_are_all_but_sure_are_not_rounded():
    assert [percent(share) for share in (0.0, 0.004, 0.5, 0.999)] == [
        "under 1 %", "under 1 %", "50 %", "over 99 %"
    ]  # fmt: skip


def test_the_chart_says_what_the_odds_were_before():
    console = Console(width=80, record=True)
    new = [HypothesisDocument(names=["end_stop"], title="end stop", odds=0.75)]
    new.append(HypothesisDocument(names=[], title="the usual model", odds=0.25))
    console.print(odds_chart(new, {"end stop": 0.5}))
    first, second = console.export_text().splitlines()[:2]
    assert first.split()[-4:] == ["%", "(was", "50", "%)"]
    assert second.rstrip().endswith("(new)")
    assert first.count("█") == 18  # three quarters of 24


def test_what_a_release_gave_stands_beside_what_was_expected_of_it():
    turn = TurnDocument(
        session="release_2", asked="", amplitude=0.025, unit="m", between=["end stop", "freeplay"]
    )
    words = gave(turn.model_copy(update={"expected_nats": 9.2, "gave_nats": 7.5}))
    assert words == "odds of 10³ to 1 for end stop against freeplay; 10⁴ to 1 for end stop expected"
    assert gave(turn.model_copy(update={"expected_nats": None, "gave_nats": None})) == ""
    assert gave(turn.model_copy(update={"expected_nats": 51.0, "gave_nats": -1.2})).startswith(
        "odds of 3 to 1 for freeplay against end stop"
    )


def test_a_rejected_recording_is_taken_again_and_at_last_given_up():
    told = first_release(limits_of("2mm,25mm"))
    limits = limits_of("2mm,25mm")
    once = _again(told, "the recording was rejected: it sticks", limits, [])
    assert once.experiment == told.experiment
    assert "it sticks" in once.words
    assert not _again(told, "it sticks", limits, ["sticks", "", "sticks"]).over  # one between them was good
    assert _again(told, "it sticks", limits, ["", "sticks", "sticks"]).state == "given_up"


def test_a_release_that_went_over_the_range_of_a_sensor_is_taken_again_from_a_smaller_amplitude(
    tmp_path, monkeypatch
):
    asked: list[tuple[float, str]] = []

    class Watching:
        observer = None

        def asks(self, number, told):
            asked.append((told.experiment.amplitude, told.words))

        def judged(self, turn, document):
            assert document is None

    clipped = Verdict(
        grade=Grade.REJECT, reasons=("it clips",), advice=("a smaller release, or a wider range",)
    )
    recorded = SimpleNamespace(folder=tmp_path / "one", verdict=clipped)
    monkeypatch.setattr(guiding, "_record", lambda *_: (recorded, ""))
    test = GuidedTest("", CaptureSettings(), limits_of("6mm,25mm"), tmp_path, Settings())
    given_up = guide(test, Watching())
    assert given_up.state == "given_up"
    assert given_up.words.endswith("Above 6 mm a sensor goes over its range.")
    first, second, third = asked
    assert second[0] == pytest.approx(SMALLER * first[0])
    assert "smaller" in second[1]
    assert third[0] == pytest.approx(0.006)  # no smaller than the limit


@pytest.mark.parametrize(("limit", "answers"), [(1e9, 1), (0.006, 0)])
def test_a_decay_that_is_cut_off_gets_no_answer_while_it_still_runs(limit, answers):
    clock = np.arange(-1000, 4000) / 500.0
    decay = np.where(clock < 0.0, 0.01, 0.01 * np.exp(-0.3 * clock) * np.cos(24.0 * clock))
    decay += np.random.default_rng(1).normal(scale=5e-6, size=len(clock))
    samples, said = np.clip(decay, -limit, limit)[np.newaxis], list[str]()
    provisional = Provisional((), (), 500.0, 8.0, said.append, CaptureObserver())
    provisional.connected(None, (Channel("displacement", "displacement", "m"),))
    provisional.block(0, samples[:, :1000])
    provisional.state("recording", "")
    provisional.block(1000, samples[:, 1000:])
    provisional._pool.shutdown()
    assert len(said) == answers


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered", "undrawn")
def test_a_newcomer_is_led_from_an_open_verdict_to_a_confirmed_one(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(guiding, "diagnose", lambda decays: diagnosed(*decays))  # among few effects
    assert run(["demo", "--guided", "5", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["state"] == "confirmed"
    assert told["named"] == [told["hidden"]["effect"]]
    assert len(told["turns"]) > 1  # one release leaves the verdict open
    assert all(turn["asked"] for turn in told["turns"])
    second = told["turns"][1]  # a third, to show what can hide, is asked for now and then
    assert second["between"][0] in second["asked"]
    assert second["gave_nats"] == pytest.approx(second["expected_nats"], rel=0.5)
    assert "cannot exclude settling stiffness" in told["words"]
    folder = tmp_path / told["folder"]
    assert (folder / "report.html").is_file()
    assert (folder / "campaign" / "campaign.json").is_file()
    assert json.loads((folder / "guide.json").read_text())["state"] == "confirmed"
