"""`station diagnose`: which effect a model lacks, how sure that is, and what to record next."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from station.commands.options import EFFECTS, FULL, GAIN, MODEL, NO_VIEWER, SESSIONS, VARIES
from station.output import json_option, print_json, progress, screen
from station.suggestions import MEASURED_CURVE
from station.text.next_step import next_line

if TYPE_CHECKING:
    from identify.diagnosis.diagnose import Diagnosis
    from station.operations.session_set import SessionSet
    from station.results.diagnosis_document import DiagnosisDocument


@click.command("diagnose")
@SESSIONS
@MODEL
@EFFECTS
@GAIN
@click.option(
    "--worth",
    type=click.FloatRange(0.0, 100.0),
    default=0.0,
    metavar="PERCENT",
    help="Name no force that removes less than this share of the motion.",
)
@VARIES
@click.option("--anyway", is_flag=True, help="Even if the sessions look like different benches.")
@FULL
@NO_VIEWER
@json_option
@click.pass_obj
def command(
    settings_file: str | None,
    sessions: tuple[str, ...],
    model_file: Path | None,
    effects_file: Path | None,
    gain_percent: float | None,
    worth: float,
    varies: str,
    anyway: bool,
    full: bool,
    no_viewer: bool,
    as_json: bool,
) -> None:
    """Find out which effect a model lacks.

    SESSION is a session or a data file; several share the physics, which is
    looked at first, but for what --varies says was changed between them.
    Without --model it is the current model: the refined one; before any
    `refine` the one that `station identify` found at orders of your choice,
    else the usual one: stiffness, dry and viscous friction.
    """
    from station.operations.diagnosing import (
        diagnose_sessions,
        keep,
        open_or_refuse,
        physics_shared,
        refuse_if_too_little,
    )
    from station.results.diagnosis_document import with_differences
    from station.settings import load_settings

    settings = load_settings(settings_file)
    opened = open_or_refuse(sessions, settings, gain_percent, as_json, varies)
    for name, why in opened.left_out.items():
        progress(f"{name} is left out: {why}")
    shared = physics_shared(opened, anyway, progress)
    found, document = diagnose_sessions(opened, model_file, effects_file, progress, worth=worth)
    if shared is not None:
        document = with_differences(document, shared)
    keep(opened, document)
    if as_json:
        print_json(document.plain())
    else:
        from station.story.engineering_values import Weighing
        from station.story.preparation import options_for
        from station.text.diagnosis_text import show_diagnosis

        options = options_for(opened.sessions[0], settings)
        unit = opened.decays[0].window.unit
        weighing = None if options.mass is None else Weighing(options.mass, options.mass_std, unit)
        show_diagnosis(screen(), document, weighing, full=full)
        for line in next_steps(opened, found, document):
            screen().print(line, markup=False, soft_wrap=True)
    refuse_if_too_little(document)
    if not no_viewer:
        from station.operations.viewer_tabs import show_suspects

        if show_suspects(opened, found, document):
            progress("the viewer shows the suspects and the curves")


def next_steps(opened: "SessionSet", found: "Diagnosis", document: "DiagnosisDocument") -> list[str]:
    """Return the commands that come next."""
    folder = opened.sessions[0].folder
    if document.differences and not found.named:
        return [next_line("diagnose", folder)]
    if found.verdict in ("missing_effect", "sensor_fault"):
        return [next_line("refine", folder, "--add", found.named[0])]
    if found.verdict == "unknown_effect" and found.shape is not None and found.shape.coordinates:
        return [next_line("refine", folder, "--add", MEASURED_CURVE)]
    if found.verdict == "nothing_missing":
        return [next_line("report", folder)]
    return []  # what to record next is said already
