"""`station demo --guided`: a guided test on a simulated rig that releases itself and hides something."""

import json
from pathlib import Path

from station.commands.guide import show_guided
from station.operations.guiding import RIG, SIMULATED, GuidedTest
from station.operations.mystery import BOARD, hidden_words
from station.operations.new_session import new_folder
from station.operations.simulated_board import on_simulated, simulated_capture
from station.output import print_json, screen
from station.results.guide_document import GuideDocument
from station.settings import Settings
from station.text.layout import labelled


def play_guided(
    settings: Settings, seed: int, speed: float, pty: bool, folder: Path | None, as_json: bool
) -> None:
    """Guide a simulated rig that hides what its seed draws, then say what that was."""
    wanted = simulated_capture(settings, f"mystery {seed}", speed)
    place = folder or new_folder(settings.sessions, "guide")

    def act(port: str) -> GuideDocument:
        return show_guided(GuidedTest(port, wanted, SIMULATED, place, settings, alone=True), as_json)

    document, envelope = on_simulated(act, seed, speed, pty, *RIG, module=BOARD)
    truth = json.loads(envelope)
    if as_json:
        hidden = {key: truth[key] for key in ("hidden", "kind", "strengths", "parameters")}
        print_json(document.plain() | {"hidden": hidden})
    else:
        screen().print(labelled("hidden was", f"{hidden_words(truth)}; it is read only now"))
