"""Right: the ladder of errors as a film, what to do at the floor, and the model with its values."""

from collections.abc import Callable
from typing import Any

from identify.formatting import plain_name
from station.operations import refining
from station.results.ladder import KeptLadder
from station.results.models import name_of
from station.workbench import tasks, widgets
from station.workbench.parts import part
from station.workbench.session_state import SessionState
from station.workbench.view_models import View


class LadderPanel:
    """Ladder and model of one session: a click goes to a step, a switch takes an effect out or puts it in again."""

    def __init__(self, session: SessionState, report: Callable[[], Any], validate: Callable[[], Any]) -> None:
        self._session = session
        does = {
            "go": self._go,
            "undo": lambda _: session.undo(),
            "remove": lambda name: session.change(f"Taking {plain_name(name)} out", refining.remove, name),
            "put_in": self._put_in,
            "report": lambda _: report(),
            "validate": lambda _: validate(),
            "prune": lambda _: session.start("Trying to do without each effect", tasks.prune, long=True),
        }
        self._place = widgets.html("contents", does)

    def show(self, view: View) -> None:
        """Show a session as it stands."""
        undo, ladder = bool(self._session.earlier), view.ladder
        self._place.content = part("fall", view, undo, switched_off(ladder))

    def _go(self, place: str) -> None:
        view = self._session.view
        if view is not None and int(place) != view.ladder.present:
            self._session.change(f"Going to step {place}", refining.go_to, int(place))

    def _put_in(self, name: str) -> None:
        if self._session.view is not None:
            wanted = expression_of(self._session.view.ladder, name) or name
            self._session.change(f"Adding {plain_name(name)}", refining.add, wanted)


def switched_off(ladder: KeptLadder) -> list[str]:
    """List the effects that stood in the model on the way to the present step, and do not now."""
    before = (name for step in ladder.steps[: ladder.present] for name in step.effects)
    return [name for name in dict.fromkeys(before) if name not in ladder.top.effects]


def expression_of(ladder: KeptLadder, name: str) -> str:
    """Find the user's own text of an effect; "" where the library has it."""
    texts = (text for step in ladder.steps for text in step.model.expressions)
    return next((text for text in texts if name_of(text) == name), "")
