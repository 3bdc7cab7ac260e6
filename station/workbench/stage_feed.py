"""What a tab knows of a session's frames: each is sent once, and what changed with it."""

import json
from dataclasses import asdict
from typing import Any

from identify.formatting import plain_name
from station.workbench import view_models
from station.workbench.session_state import SessionState
from station.workbench.statements import says_of
from station.workbench.widgets import run


class StageFeed:
    """Sends one tab what its pictures need."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._stage: view_models.Stage | None = None
        self._sent: set[str] = set()

    @property
    def whole(self) -> bool:
        """Whether every step's frame was sent."""
        view = self._session.view
        return view is not None and all(name in self._sent for name in view.step_frames)

    def send(self) -> None:
        """Send what is new since the last time."""
        view = self._session.view
        if view is None or view.stage is None:
            return
        document = view.diagnosis if view.about_present and not view.at_floor else None
        present = view.ladder.top.effects
        suspects = {e: name for e, name in self._session.suspect_frames.items() if e not in present}
        says = says_of(view, self._session.summary)
        for effect, frame in suspects.items():  # what stands in no diagnosis says of itself what it leaves
            if effect not in says and frame in self._session.frames:
                says[effect] = self._session.frames[frame].says
        news: dict[str, Any] = {
            "steps": list(view.step_frames),
            "present": view.ladder.present,
            "busy": self._session.busy,
            "suspects": suspects,
            "best": document.named[0] if document is not None and document.named else None,
            "says": says,
            "names": {name: plain_name(name) for name in says},
        }
        if self._stage is None or self._stage.time != view.stage.time:
            news["stage"] = asdict(view.stage)
            self._sent.clear()
        self._stage = view.stage
        wanted = {*view.step_frames, *suspects.values()}
        fresh = {n: f for n, f in self._session.frames.items() if n in wanted and n not in self._sent}
        self._sent = (self._sent | fresh.keys()) & (wanted | self._sent)
        news["frames"] = {name: asdict(frame) for name, frame in fresh.items()}
        run(f"bench.receive({json.dumps(news)})")
