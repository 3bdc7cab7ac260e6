"""What a click on an element of `parts.html` does to a session, by the name that the element carries."""

from collections.abc import Callable
from typing import Any

from identify.formatting import plain_name
from station.operations import refining
from station.workbench import further_tasks, tasks
from station.workbench.session_state import SessionState
from station.workbench.worker import Failed


def actions(
    session: SessionState, report: Callable[[], Any], validate: Callable[[], Any]
) -> dict[str, Callable[[str], Any]]:
    """Return the actions of the cards, the ladder and the model; `report` and `validate` are those of the page."""

    async def reveal(_: str) -> None:
        try:
            session.notice = await session.ask(further_tasks.reveal)
        except Failed as failure:
            session.notice = str(failure)
        session.changed()

    return {
        "add": session.add,
        "diagnose": lambda _: session.diagnose(),
        "refine": lambda _: session.start("Refining", tasks.refine, long=True),
        "reveal": reveal,
        "go": lambda place: session.change(f"Going to step {place}", refining.go_to, int(place)),
        "undo": lambda _: session.undo(),
        "remove": lambda name: session.change(f"Taking {plain_name(name)} out", refining.remove, name),
        "report": lambda _: report(),
        "validate": lambda _: validate(),
        "prune": lambda _: session.change("Trying to do without each effect", refining.drop_needless),
    }
