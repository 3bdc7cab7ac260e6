"""`station demo --guided`: a guided test on a simulated rig that releases itself and hides something."""

import json
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from daq.session_info import SessionInfo
from station.commands.guide import show_guided
from station.exits import DONE
from station.operations.guiding import RIG, SIMULATED, GuidedTest
from station.operations.mystery import BOARD, MASS_KG, hidden_words
from station.operations.new_session import capture_settings, new_folder
from station.operations.simulated_board import simulated_board
from station.output import print_json, screen
from station.settings import load_settings
from station.text.layout import labelled


def play_guided(
    settings_file: str | None, seed: int, speed: float, pty: bool, folder: Path | None, as_json: bool
) -> int:
    """Guide a simulated rig that hides what its seed draws, then say what that was; return the exit code."""
    settings = load_settings(settings_file)
    info = SessionInfo(specimen=f"mystery {seed}", mass_kg=MASS_KG, operator="demo")
    wanted = replace(capture_settings(settings, info), check_clock=speed == 1.0)
    place = folder or new_folder(settings.sessions, "guide")
    with TemporaryDirectory() as temporary:
        envelope = Path(temporary) / "truth.json"
        with simulated_board(seed, speed, pty, *RIG, "--truth", str(envelope), module=BOARD) as port:
            document = show_guided(GuidedTest(port, wanted, SIMULATED, place, settings, alone=True), as_json)
        truth: dict[str, Any] = json.loads(envelope.read_text(encoding="utf-8"))
    hidden = {key: truth[key] for key in ("hidden", "kind", "strengths", "parameters")}
    if as_json:
        print_json(document.plain() | {"hidden": hidden})
    else:
        screen().print(labelled("hidden was", f"{hidden_words(truth)}; it is read only now"))
    return DONE
