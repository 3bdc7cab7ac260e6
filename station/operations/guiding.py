"""A guided test: it asks for a release, records and judges it with all before, until that has settled what is missing."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import copysign
from pathlib import Path
from typing import Any, Protocol

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.quality import Grade
from daq.session import Session
from daq.storage import write_whole
from identify.diagnosis.diagnose import Diagnosis, diagnose
from identify.diagnosis.guidance import Guidance, first_release, guidance, what_it_gave
from identify.errors import NotIdentifiable
from identify.planning.experiment import Experiment
from identify.planning.next_release import Limits
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import UsageProblem
from station.operations.diagnosing import keep
from station.operations.new_session import metres
from station.operations.provisional import Provisional
from station.operations.session_set import SessionSet
from station.output import progress
from station.results.diagnosis_document import DiagnosisDocument, diagnosis_document, next_release_document
from station.results.documents import picked
from station.results.guide_document import NAME, GuideDocument, TurnDocument
from station.settings import Settings
from station.story.preparation import prepare_session

RIG = ("--holder=-25,25", "--releases=20")
"""Of the simulated board: between which displacements (mm) it holds the mass, and at which what it hides has its size."""

SIMULATED = Limits(0.002, 0.025, ways=("longer", "rest"))
"""What the simulated rig allows."""

MOST_TAKES = 3
"""Recordings in a row that may tell nothing."""

SMALLER = 0.7
"""Share of the amplitude of a release that went over a sensor's range from which the next ones are taken at most."""


class Watcher(Protocol):
    """An observer of a guided test; `observer` watches its captures."""

    observer: CaptureObserver

    def asks(self, number: int, told: Guidance) -> None:
        """A release is wanted, for a reason."""

    def provisional(self, answer: str) -> None:
        """A first answer while the decay is still running."""

    def judged(self, turn: TurnDocument, document: DiagnosisDocument | None) -> None:
        """A release was judged together with all before."""


@dataclass(frozen=True, eq=False)
class GuidedTest:
    """What a guided test is given: a `port` that may be opened for each release, how to capture, the rig's limits.

    `alone`: the rig holds and releases the mass itself. `begin` is the folder of its sessions.
    """

    port: str
    capture: CaptureSettings
    limits: Limits
    folder: Path
    settings: Settings
    alone: bool = False


def guide(test: GuidedTest, watcher: Watcher, cancelled: Callable[[], bool] = lambda: False) -> GuideDocument:
    """Run a guided test; all its sessions lie in one folder, with the document that is returned.

    Raises the StationError of a capture that fails; what was judged before is kept.
    """
    limits, turns = test.limits, list[TurnDocument]()
    told = first_release(limits)
    sessions, decays = tuple[Session, ...](), tuple[PreparedDecay, ...]()
    before: Diagnosis | None = None
    while not told.over and not cancelled():
        assert told.experiment is not None
        watcher.asks(len(turns) + 1, told)
        session, answer = _record(test, told.experiment, len(turns) + 1, decays, before, watcher)
        began = time.monotonic()
        turn = {
            "session": session.folder.name,
            "asked": told.words,
            "amplitude": told.experiment.amplitude,
            "unit": "m",
            "provisional": answer,
        }
        document = None
        verdict = session.verdict
        if verdict is not None and verdict.grade is Grade.REJECT:
            turn["problem"] = rejected = f"the recording was rejected: {'; '.join(verdict.reasons)}"
            if any(one.startswith("a smaller release") for one in verdict.advice):
                most = SMALLER * abs(told.experiment.amplitude)
                limits = replace(limits, high=max(limits.low, min(limits.high, most)))
            told = _again(told, rejected, limits, [one.problem for one in turns])
        else:
            try:
                prepared = prepare_session(session, test.settings)
                trial = SessionSet((*sessions, session), (*decays, prepared))
                found = diagnose(trial.decays)
            except NotIdentifiable as refusal:
                turn["problem"] = str(refusal)
                told = _instead(told, limits, str(refusal))
            else:
                turn |= _gave(told, before, found)
                sessions, decays, before = trial.sessions, trial.decays, found
                told = guidance(found, len(sessions), limits)
                document = diagnosis_document(trial.names, found)
                turn |= picked(document, "verdict", "named", "hypotheses") | {
                    "next_release": next_release_document(told.chosen),
                    "judged_s": time.monotonic() - began,
                }
                keep(trial, document, progress)
        turns.append(TurnDocument.model_validate(turn))
        watcher.judged(turns[-1], document)
        _keep(test, turns, told)
    if limits != test.limits:
        beyond = f"Above {1e3 * limits.high:.3g} mm a sensor goes over its range."
        told = replace(told, words=f"{told.words} {beyond}")
    return _keep(test, turns, told)


def limits_of(text: str, unattended: bool = False) -> Limits:
    """Return the limits of a rig from "2mm,25mm"; UsageProblem for what is none."""
    lengths = [length for word in text.split(",") if (length := metres(word)) is not None]
    if len(lengths) != 2 or text.count(",") != 1 or not 0.0 < lengths[0] < lengths[1]:
        raise UsageProblem(
            f"--limits {text}: write the smallest and the largest safe amplitude with their units, as 2mm,25mm"
        )
    ways = ("longer", "rest") if unattended else ("push", "longer", "rest")
    return Limits(lengths[0], lengths[1], ways=ways)


def _record(
    test: GuidedTest,
    experiment: Experiment,
    number: int,
    decays: tuple[PreparedDecay, ...],
    before: Diagnosis | None,
    watcher: Watcher,
) -> tuple[Session, str]:
    wanted = replace(
        test.capture,
        duration_s=test.capture.duration_s * experiment.longer,
        release_from=experiment.amplitude if test.alone else None,
    )
    hypotheses = () if before is None else before.hypotheses
    provisional = Provisional(
        decays, hypotheses, wanted.rate_hz, wanted.duration_s, watcher.provisional, watcher.observer
    )
    folder = test.folder / f"{test.folder.name}_{number}"
    try:
        session = capture(test.port, wanted, folder, provisional)
    finally:
        provisional.close()
    return session, provisional.answer


def _again(told: Guidance, reason: str, limits: Limits, before: list[str]) -> Guidance:
    """Return the same release again, as large as the limits allow, unless the recordings before it were rejected too."""
    if len(before) >= MOST_TAKES - 1 and all(before[1 - MOST_TAKES :]):
        return Guidance("given_up", f"{MOST_TAKES} recordings in a row gave no result: {reason}")
    assert told.experiment is not None
    asked = told.experiment.amplitude
    if abs(asked) <= limits.high:
        return replace(told, words=f"Once more, for {reason}.")
    smaller = replace(told.experiment, amplitude=copysign(limits.high, asked))
    return replace(told, words=f"Once more from a smaller amplitude, for {reason}.", experiment=smaller)


def _instead(told: Guidance, limits: Limits, reason: str) -> Guidance:
    """Decide what follows a release without a result: the largest amplitude, once; then the test is given up."""
    assert told.experiment is not None
    if abs(told.experiment.amplitude) >= 0.99 * limits.high:
        return Guidance("given_up", f"The largest release gave no result: {reason}")
    side = 1.0 if told.experiment.amplitude > 0.0 else -1.0
    return Guidance(
        "go_on",
        f"That release gave no result ({reason}). The largest amplitude shows most.",
        Experiment(side * limits.high),
    )


def _gave(told: Guidance, before: Diagnosis | None, found: Diagnosis) -> dict[str, Any]:
    """Return the evidence between two hypotheses that a release was expected to give, and gave; empty without these."""
    gave = None if before is None else what_it_gave(told, before, found)
    if gave is None or told.chosen is None:
        return {}
    chosen = told.chosen
    return {"between": list(chosen.between), "expected_nats": chosen.best.nats, "gave_nats": gave}


def _keep(test: GuidedTest, turns: list[TurnDocument], told: Guidance) -> GuideDocument:
    limits = test.limits
    document = GuideDocument.of(
        told, format=1, folder=str(test.folder), low=limits.low, high=limits.high, turns=turns
    )
    write_whole(test.folder / NAME, document.model_dump_json(indent=1).encode() + b"\n")
    return document
