"""`station recover`: seal what a power cut or a crash left open."""

from typing import Any

import click

from station.output import json_option, print_json, screen
from station.text.next_step import next_line


@click.command("recover")
@click.argument("sessions", nargs=-1)
@json_option
@click.pass_obj
def command(settings_file: str | None, sessions: tuple[str, ...], as_json: bool) -> None:
    """Seal SESSIONS that were cut off (default: all unsealed ones).

    Everything up to the last whole record is kept; the raw bytes are never
    touched.
    """
    from daq.session import recover, unsealed_sessions
    from station.results.session_names import session_folder
    from station.settings import load_settings

    root = load_settings(settings_file).sessions
    if sessions:
        folders = [session_folder(name, root) for name in sessions]
    else:
        folders = list(unsealed_sessions(root)) if root.is_dir() else []
    recovered = [recover(folder) for folder in folders]
    if as_json:
        print_json({"sessions": [_entry(session) for session in recovered]})
        return
    if not recovered:
        screen().print("nothing to recover: every session is sealed", markup=False)
    for session in recovered:
        entry = _entry(session)
        screen().print(
            f"{entry['session']}: {entry['state']}, {entry['samples']} samples", markup=False, soft_wrap=True
        )
        if entry["reason"]:
            screen().print(f"  {entry['reason']}", markup=False)
    following = next_line("identify", recovered[0].folder) if recovered else next_line("list")
    screen().print(following, markup=False, soft_wrap=True)


def _entry(session: Any) -> dict[str, Any]:
    counts = session.manifest().counts
    verdict = session.verdict
    return {
        "session": str(session.folder),
        "state": session.info.state.value,
        "reason": session.info.reason,
        "samples": counts.samples,
        "lost_samples": counts.lost,
        "verdict": None if verdict is None else verdict.grade.value,
    }
