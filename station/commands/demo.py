"""`station demo`: run the whole job on a simulated board."""

from pathlib import Path
from typing import Any

import click

from station.commands.options import NO_VIEWER, declared, new_session_option, option
from station.settings import Settings
from station.text.content import Paragraph, Table, Told, facts

SPEED = 4.0
MADE_OF = ("stiffness", "mu_0", "mu_1", "displacement_late_s", "seed")


@declared("demo")
def command(
    settings: Settings,
    seed: int = option("Seed of the random bench, sensors, lag and release.", default=6, show_default=True),
    speed: float = option(
        "Speed in multiples of real time; 0: as fast as possible.",
        type=click.FloatRange(min=0),
        default=SPEED,
        show_default=True,
    ),
    mystery: int | None = option("Hide an effect, find it.", is_flag=False, flag_value=-1, metavar="[SEED]"),
    guided: int | None = option(
        "Hide an effect; be guided to its name.", is_flag=False, flag_value=5, metavar="[SEED]"
    ),
    example: str | None = option("Identify a recording that comes with the station.", metavar="NAME"),
    listed: bool = option("List the recordings that come with the station.", "--list"),
    folder: Path | None = new_session_option("Folder of the new session (default: ./sessions/demo_TIME)."),
    no_viewer: bool = NO_VIEWER,
) -> None:
    """Run the whole job on a simulated board: capture, align, identify, show.

    The board is `python -m mocks`, a process of its own; the station connects
    to its port as it would to any. Or, without any board, identify one of the
    recordings that come with the station: `--list`, `--example NAME`.
    """
    if listed:
        _list()
    elif example is not None:
        from station.commands.capture import finish
        from station.operations.examples import open_example

        finish(open_example(example, settings.sessions), None, settings)
    elif guided is not None:
        _guided(settings, guided, speed, folder)
    elif mystery is not None:
        from station.operations.mystery import play

        play(settings, mystery if mystery >= 0 else None, speed, folder, no_viewer)
    else:
        from station.commands.capture import finish
        from station.operations.new_session import new_folder
        from station.operations.simulated_board import record_simulated

        where = folder or new_folder(settings.sessions, "demo")
        specimen = f"simulated testbed, seed {seed}"
        session, shown_at, truth = record_simulated(
            settings, specimen, seed, speed, where, not no_viewer, "mocks"
        )
        made_of = {name: truth[name] for name in MADE_OF}
        finish(session, shown_at, settings, (_made_of(truth),), made_of=made_of)


def _guided(settings: Settings, seed: int, speed: float, folder: Path | None) -> None:
    """Guide a simulated rig that releases itself and hides what its seed draws, then say what that was."""
    from station.operations.guiding import RIG, SIMULATED, GuidedTest
    from station.operations.mystery import BOARD, hidden_document, hidden_words
    from station.operations.new_session import new_folder
    from station.operations.simulated_board import simulated_capture, told_board
    from station.report.write import show_guided
    from station.text.layout import answer

    wanted = simulated_capture(settings, f"mystery {seed}", speed)
    place = folder or new_folder(settings.sessions, "guide")
    with told_board(seed, speed, *RIG, module=BOARD) as (port, truth):
        document = show_guided(GuidedTest(port, wanted, SIMULATED, place, settings, alone=True))
    words = facts([("hidden was", f"{hidden_words(truth)}; it is read only now")])
    answer(document.plain() | {"hidden": hidden_document(truth)}, Told("", "", words))


def _list() -> None:
    """List the recordings that come with the station."""
    from station.operations.examples import EXAMPLES
    from station.text.layout import answer

    document = {"examples": [{"name": e.name, "file": e.file, "about": e.about} for e in EXAMPLES]}
    table = Table("", ("", ""), tuple((one.name, one.about) for one in EXAMPLES), texts=2)
    answer(document, Told("", "", (table,)), "demo", "--example", EXAMPLES[0].name)


def _made_of(truth: dict[str, Any]) -> Paragraph:
    from station.operations.simulated_board import MASS_KG

    return Paragraph(
        f"K {truth['stiffness']:.2f} N/m, μ₀ {MASS_KG * truth['mu_0']:.4f} N, μ₁ {MASS_KG * truth['mu_1']:.4f} N s/m, "
        f"lag {truth['displacement_late_s'] * 1e6:.1f} µs",
        label="the simulated board has, unknown to the station",
    )
