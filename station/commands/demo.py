"""`station demo`: the whole job on a simulated board, which runs as a program of its own."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from station.commands.options import NO_VIEWER, new_session_option
from station.output import json_option, print_json, progress

SPEED = 4.0
MADE_OF = ("stiffness", "mu_0", "mu_1", "displacement_late_s", "seed")


@click.command("demo")
@click.option("--seed", type=int, default=6, show_default=True, help="Draws bench, sensors, lag and release.")
@click.option(
    "--speed",
    type=click.FloatRange(min=0),
    default=SPEED,
    show_default=True,
    help="Times real time; 0: as fast as it goes.",
)
@click.option(
    "--mystery", is_flag=False, flag_value=-1, type=int, metavar="[SEED]", help="Hide an effect, find it."
)
@click.option(
    "--guided",
    is_flag=False,
    flag_value=5,
    type=int,
    metavar="[SEED]",
    help="Hide an effect; be guided to its name.",
)
@click.option("--example", metavar="NAME", help="Identify a recording that comes with the station.")
@click.option("--list", "listed", is_flag=True, help="List the recordings that come with the station.")
@click.option("--pty", is_flag=True, help="Connect through a pseudo terminal instead of TCP.")
@new_session_option("Folder of the new session (default: ./sessions/demo_TIME).")
@NO_VIEWER
@json_option
@click.pass_obj
def command(
    settings_file: str | None,
    seed: int,
    speed: float,
    mystery: int | None,
    guided: int | None,
    example: str | None,
    listed: bool,
    pty: bool,
    folder: Path | None,
    no_viewer: bool,
    as_json: bool,
) -> int | None:
    """Run the whole job on a simulated board: capture, align, identify, show.

    The board is `python -m mocks`, a process of its own; the station connects
    to its port as it would to any. Or, without any board, identify one of the
    recordings that come with the station: `--list`, `--example NAME`.
    """
    if listed or example is not None:
        _examples(settings_file, example, as_json)
        return None
    if guided is not None:
        from station.commands.guided_demo import play_guided

        return play_guided(settings_file, guided, speed, pty, folder, as_json)
    from dataclasses import replace

    from daq.session_info import SessionInfo
    from station.commands.capture import finish
    from station.operations.capturing import record
    from station.operations.new_session import capture_settings, new_folder
    from station.operations.simulated_board import simulated_board
    from station.settings import load_settings

    settings = load_settings(settings_file)
    if mystery is not None:
        from station.operations.mystery import play

        play(settings, mystery if mystery >= 0 else None, speed, pty, folder, no_viewer, as_json)
        return None
    info = SessionInfo(specimen=f"simulated testbed, seed {seed}", mass_kg=21.36, operator="demo")
    wanted = replace(capture_settings(settings, info), check_clock=speed == 1.0)
    where = folder or new_folder(settings.sessions, "demo")
    with TemporaryDirectory() as temporary:
        truth_file = Path(temporary) / "truth.json"
        with simulated_board(seed, speed, pty, "--truth", str(truth_file)) as port:
            progress(f"a simulated board answers at {port}")
            session, url = record(port, wanted, where, not no_viewer)
        truth = json.loads(truth_file.read_text(encoding="utf-8"))
    made_of = {name: truth[name] for name in MADE_OF}
    finish(session, url, settings, as_json, _made_of(truth), made_of=made_of)
    return None


def _examples(settings_file: str | None, name: str | None, as_json: bool) -> None:
    """List the recordings that come with the station, or import one and identify it."""
    from station.operations.examples import EXAMPLES, example

    if name is not None:
        example(name)  # a typo is answered before the numerics are loaded
    if name is None:
        if as_json:
            print_json({"examples": [{"name": e.name, "file": e.file, "about": e.about} for e in EXAMPLES]})
            return
        for one in EXAMPLES:
            click.echo(f" {one.name:<20}{one.about}")
        click.echo(f"\n try one: station demo --example {EXAMPLES[0].name}")
        return
    from station.operations.examples import open_example
    from station.operations.identifying import identify_session, refuse_if_nothing
    from station.settings import load_settings
    from station.story.preparation import options_for
    from station.text.identification_text import next_command, told
    from station.text.layout import tell

    settings = load_settings(settings_file)
    session = open_example(name, settings.sessions)
    result, document = identify_session(session, options_for(session, settings))
    if as_json:
        print_json({"session": str(session.folder), "identification": document.plain()})
    else:
        tell(told(session.folder.name, result), next_command(result), session.folder)
    refuse_if_nothing(result)


def _made_of(truth: dict[str, Any]) -> str:
    return (
        " the simulated board was made with (which the station did not know):\n"
        f"   K {truth['stiffness']:.2f} N/m, mu_0 {truth['mu_0']:.5f} m/s^2, mu_1 {truth['mu_1']:.5f} 1/s,"
        f" lag {truth['displacement_late_s'] * 1e6:.1f} us\n"
    )
