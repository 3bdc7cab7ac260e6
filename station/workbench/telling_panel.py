"""A result that a worker tells: asked for when it is first looked at, and again when what it rests on has changed."""

import asyncio
from collections.abc import Callable

from station.text.content import Told
from station.workbench import telling, widgets
from station.workbench.parts import part
from station.workbench.session_state import SessionState
from station.workbench.waiting import Waiting
from station.workbench.worker import Failed


class TellingPanel:
    """What a function of a worker tells of a session, empty until it is opened; `doing` says what it does meanwhile."""

    def __init__(self, session: SessionState, what: Callable[..., Told | str], doing: str) -> None:
        self._session, self._what, self._doing = session, what, doing
        self._waiting = Waiting(session.workers)
        self._wanted: object = None
        self._body = widgets.html("told")

    async def open(self, *arguments: object) -> None:
        """Show what is told with `arguments`, unless that is shown already of the session as it stands."""
        view, folder = self._session.view, self._session.folder
        wanted = (None if view is None else view.stamp, arguments)
        if wanted == self._wanted:
            return
        self._waiting.cancel()
        self._wanted = wanted
        try:
            told = (folder, self._what, *arguments)
            self._body.content = await self._waiting.do(self._doing, str(folder), telling.tell, *told)
        except (asyncio.CancelledError, Failed) as failure:
            if self._wanted == wanted:
                self._wanted = None
                said = str(failure) or "Cancelled; ask again to see it."
                self._body.content = part("told", Told(said, "bad", ()))

    def cancel(self) -> None:
        """End what is under way."""
        self._waiting.cancel()
