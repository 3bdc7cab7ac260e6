"""The frames of a session that a tab has: each is sent once, with its changes."""

import json
from typing import Any

from nicegui import ui

from identify.formatting import plain_name
from station.workbench.session_state import SessionState
from station.workbench.statements import says_of
from station.workbench.view_models import Drawing


class StageFeed:
    """Sends one tab what its pictures need."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._stage: Drawing = {}
        self._sent: set[str] = set()

    @property
    def whole(self) -> bool:
        """Whether every step's frame was sent."""
        view = self._session.view
        return view is not None and self._sent.issuperset(view.step_frames)

    def send(self) -> None:
        """Send what is new since the last time."""
        session, view = self._session, self._session.view
        if view is None or not view.stage:
            return
        document = view.diagnosis if view.about_present and not view.at_floor else None
        present = view.ladder.top.effects
        suspects = {e: name for e, name in session.suspects.suspects.items() if e not in present}
        says = session.suspects.says | says_of(view, session.summary)
        news: dict[str, Any] = {
            "steps": list(view.step_frames),
            "present": view.ladder.present,
            "suspects": suspects,
            "best": document.named[0] if document is not None and document.named else None,
            "says": says,
            "names": {name: plain_name(name) for name in says},
        }
        if self._stage.get("time") != view.stage["time"]:
            news["stage"] = view.stage
            self._sent.clear()
        self._stage = view.stage
        wanted = {*view.step_frames, *suspects.values()} - self._sent
        news["frames"] = {name: frame for name, frame in session.frames.items() if name in wanted}
        self._sent.update(news["frames"])
        ui.run_javascript(f"bench.receive({json.dumps(news)})")
