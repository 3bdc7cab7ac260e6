"""`station validate`: say how well a model predicts other sessions."""

from pathlib import Path

from station.commands.options import EFFECTS, SESSIONS, VARIES, argument, declared, option
from station.output import progress
from station.settings import Settings


@declared("validate")
def command(
    settings: Settings,
    model: str = argument(),
    sessions: tuple[str, ...] = SESSIONS,
    effects_file: Path | None = EFFECTS,
    varies: tuple[str, ...] = VARIES,
    hold: bool = option("Hold the linear spring and the viscous part too."),
) -> None:
    """Say how well a model predicts sessions that it was not fitted to.

    MODEL is a model file, or a session that was refined or diagnosed. Its
    physics is held; start, zero, lag, gain and offsets of each SESSION are
    refitted, and its linear spring and damper, which may differ by some 2 %
    and 100 %;
    what --varies says was changed is each SESSION's own.
    The usual model predicts under the same rule.
    """
    from station.operations.validating import validate_sessions
    from station.text.layout import answer
    from station.text.validation_text import told

    document = validate_sessions(
        model, sessions, settings, effects_file, hold=hold, varies=varies, progress=progress
    )
    better = document.verdict == "predicts_better"
    step = ("report", sessions[0]) if better else ("diagnose", *sessions)
    answer(document.plain(), told(document), *step)
