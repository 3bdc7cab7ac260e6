"""Where a session goes when its disk fails, and what is said when there is no place left."""

from pathlib import Path

import numpy as np
import pytest

from daq.errors import StorageError
from daq.failover import PLACES, SessionWriter
from daq.import_log import import_log
from daq.recording import Channel, Recording
from daq.session import Session, SessionInfo, State, verify


def writer(folder: Path, fallback: object) -> SessionWriter:
    samples = np.sin(np.arange(64) / 5.0)[np.newaxis]
    recording = Recording(64.0, (Channel("u", "displacement", "m"),), samples, np.ones(64, dtype=bool))
    return SessionWriter.begin(folder, SessionInfo(), import_log(recording), fallback, 0)  # type: ignore[arg-type]


def test_when_every_place_refuses_the_reason_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    places = iter(range(100))
    begun = writer(tmp_path / "s", lambda _: tmp_path / str(next(places)))

    def refuse(*_: object, **__: object) -> None:
        raise StorageError("the disk is full")

    monkeypatch.setattr(Session, "seal", refuse)
    with pytest.raises(StorageError, match="no place was found for the session: the disk is full") as said:
        begun.finish(State.SEALED, "", {})
    assert next(places) < PLACES
    assert said.value.session is not None
    assert said.value.session.is_dir()


def test_the_last_of_the_places_that_are_tried_is_good_enough(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = iter(range(100))
    begun = writer(tmp_path / "s", lambda _: tmp_path / str(next(places)))
    seal = Session.seal

    def refuse(session: Session, *given: object, **named: object) -> object:
        if session.folder.name != str(PLACES - 2):
            raise StorageError("the disk is full")
        return seal(session, *given, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(Session, "seal", refuse)
    assert begun.finish(State.SEALED, "", {}).folder == tmp_path / str(PLACES - 2)
    assert verify(tmp_path / str(PLACES - 2)).ok
