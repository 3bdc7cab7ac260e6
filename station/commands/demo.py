"""`station demo`: the whole job on a simulated board, which runs as a program of its own."""

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from station.exits import Problem
from station.output import json_option, print_json, progress, screen

SPEED = 4.0
MADE_OF = ("stiffness", "mu_0", "mu_1", "displacement_late_s", "seed")
START_S = 60.0


@click.command("demo")
@click.option("--seed", type=int, default=6, show_default=True, help="Draws bench, sensors, lag and hand.")
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
@click.option("--pty", is_flag=True, help="Connect through a pseudo terminal instead of TCP.")
@click.option(
    "--session",
    "folder",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="Folder of the new session (default: ./sessions/demo_TIME).",
)
@click.option("--no-viewer", is_flag=True, help="Do not open the viewer.")
@json_option
@click.pass_obj
def command(
    settings_file: str | None,
    seed: int,
    speed: float,
    mystery: int | None,
    pty: bool,
    folder: Path | None,
    no_viewer: bool,
    as_json: bool,
) -> None:
    """Run the whole job on a simulated board: capture, align, identify, show.

    The board is `python -m mocks`, a process of its own; the station connects
    to its port as it would to any.
    """
    from dataclasses import replace

    from daq.session_info import SessionInfo
    from station.capturing import new_folder, record
    from station.commands.capture import capture_settings
    from station.identifying import identify_session, options_for, refuse_if_nothing
    from station.settings import load_settings
    from station.terminal import next_steps, show_identification

    settings = load_settings(settings_file)
    if mystery is not None:
        from station.mystery import play

        play(settings, mystery if mystery >= 0 else None, speed, pty, folder, no_viewer, as_json)
        return
    info = SessionInfo(specimen=f"simulated testbed, seed {seed}", mass_kg=21.36, operator="demo")
    wanted = replace(capture_settings(settings, info), check_clock=speed == 1.0)
    where = folder or new_folder(settings.sessions, "demo")
    with TemporaryDirectory() as aside:
        told_by_double = Path(aside) / "truth.json"
        with double(seed, speed, pty, "--truth", str(told_by_double)) as port:
            progress(f"a simulated board answers at {port}")
            session, url = record(port, wanted, where, not no_viewer)
        truth = json.loads(told_by_double.read_text(encoding="utf-8"))
    result, document = identify_session(session, options_for(session, settings))
    if not as_json:
        show_identification(screen(), session.folder.name, result)
        screen().print(_made_of(truth), markup=False, soft_wrap=True)
    from station.capturing import show_result

    file = show_result(url, session, result)
    verdict = session.verdict
    told: dict[str, Any] = {
        "session": str(session.folder),
        "viewer_recording": str(file),
        "verdict": None if verdict is None else verdict.model_dump(mode="json"),
        "identification": document,
        "made_of": {name: truth[name] for name in MADE_OF},
    }
    if as_json:
        print_json(told)
    else:
        screen().print(f" viewer's recording: {file}", markup=False, soft_wrap=True)
        next_steps(screen(), session.folder)
    refuse_if_nothing(result)


def _made_of(truth: dict[str, Any]) -> str:
    return (
        " the simulated board was made with (and the station was not told):\n"
        f"   K {truth['stiffness']:.2f} N/m, mu_0 {truth['mu_0']:.5f} m/s^2, mu_1 {truth['mu_1']:.5f} 1/s,"
        f" lag {truth['displacement_late_s'] * 1e6:.1f} us\n"
    )


@contextlib.contextmanager
def double(seed: int, speed: float, pty: bool, *more: str, module: str = "mocks") -> Iterator[str]:
    """Start the simulated board, give the name of its port, and end it afterwards."""
    line = ["--pty"] if pty else ["--tcp", "0"]
    arguments = [*line, "--seed", str(seed), "--speed", f"{speed:g}", *more]
    process = subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        first = process.stdout.readline().strip()
        if not first.startswith("port: "):
            process.kill()
            said = process.communicate()[1].strip().splitlines()
            raise Problem(f"the simulated board did not start: {said[-1] if said else 'it said nothing'}")
        yield first.removeprefix("port: ")
    finally:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(timeout=5)
        if process.poll() is None:
            process.kill()
            process.wait()
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream is not None:
                stream.close()
