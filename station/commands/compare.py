"""`station compare`: say by how much a model fails on a session, and where."""

from pathlib import Path

from station.commands.options import EFFECTS, FULL, MODEL, SESSION, declared
from station.settings import Settings


@declared("compare")
def command(
    settings: Settings,
    session: str = SESSION,
    model_file: Path | None = MODEL,
    effects_file: Path | None = EFFECTS,
    full: bool = FULL,
) -> None:
    """Compare a model with SESSION: how large its errors are, and where.

    The residual beside the noise, a sensor or physics, the worst places in
    words; --full adds noise and harmonics. Without --model it is the session's current
    model: the refined one, and before any `refine` the one that it begins with.
    """
    from station.operations.diagnosing import compare_session
    from station.results.sessions import open_session
    from station.text.comparison_text import told
    from station.text.layout import answer

    opened = open_session(session, settings.sessions)
    compared, document = compare_session(opened, settings, model_file, effects_file)
    judged = compared.judged
    step = "report" if judged.at_floor and judged.floor_is_sure else "diagnose"
    answer(document, told(compared), step, opened.folder, full=full)
