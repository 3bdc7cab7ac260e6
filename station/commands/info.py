"""`station info`: show what a session holds."""

from typing import Any

from station.commands.options import SESSION, declared
from station.exits import UsageProblem
from station.settings import Settings


@declared("info")
def command(
    settings: Settings,
    session: str = SESSION,
) -> None:
    """Show what SESSION holds: metadata, channels, losses, verdict, results."""
    from identify.errors import NotIdentifiable
    from identify.formatting import plain_name
    from identify.preprocessing.release import find_releases
    from station.operations.current_model import current_model
    from station.results.documents import picked
    from station.results.sessions import open_session
    from station.story.preparation import Options, free_decay, length_unit
    from station.text.content import Told, facts
    from station.text.layout import answer

    opened = open_session(session, settings.sessions)
    recording = opened.recording()
    manifest = opened.manifest() if opened.verdict is not None else None
    verdict = None if manifest is None else manifest.verdict
    try:
        current = current_model((opened,))
        names = list(current.model.names)
        model = f"{current.words}: {' + '.join(plain_name(name) for name in names)}"
    except UsageProblem as problem:  # an effect of the user's own file, which is not at hand here
        names, model = None, str(problem)
    document: dict[str, Any] = {
        "session": str(opened.folder),
        **opened.info.model_dump(mode="json"),
        "samples": int(recording.samples.shape[1]),
        "lost_samples": int((~recording.valid).sum()),
        "channels": [picked(channel, "name", "quantity", "unit", "sensor") for channel in recording.channels],
        "gaps": [picked(gap, "first", "count", "reason") for gap in recording.gaps],
        "flags": [] if manifest is None else [flag.model_dump() for flag in manifest.flags],
        "notes": list(recording.notes),
        "verdict": None if verdict is None else verdict.model_dump(mode="json"),
        "model": names,
        "results": sorted(path.name for path in opened.results.iterdir()) if opened.results.is_dir() else [],
    }
    words = Told(
        str(opened.folder), "", facts(_rows(document, recording.rate, length_unit(recording), model))
    )
    steps = {"identification.json": "identify", "comparison.json": "compare", "diagnosis.json": "diagnose"}
    missing = [command for name, command in steps.items() if name not in document["results"]]
    step = "report" if "ladder.json" in document["results"] or not missing else missing[0]
    following = [step, str(opened.folder)]
    try:
        find_releases(free_decay(recording, Options()))
    except NotIdentifiable:  # nothing can be made of it
        following = []
    answer(document, words, *following)


def _rows(document: dict[str, Any], rate: float, length: str, model: str) -> list[tuple[str, str]]:
    from station.story.engineering_values import Weighing
    from station.text.identification_text import flagged_lines, mass_words, sampling

    sampled, verdict = sampling(document["samples"], rate, document["rate_std_hz"]), document["verdict"]
    return [
        ("made", document["created"]),
        ("state", ": ".join(filter(None, (document["state"], document["reason"])))),
        ("source", document["source_file"] or document["source"]),
        ("operator", document["operator"]),
        ("specimen", document["specimen"]),
        ("mass", mass_words(Weighing(document["mass_kg"], document["mass_std_kg"], length))),
        ("record", f"{sampled}, {document['lost_samples']} lost"),
        ("channels", ", ".join(f"{c['name']} [{c['unit']}]" for c in document["channels"])),
        ("model", model),
        ("results", ", ".join(document["results"]) or "none yet"),
        ("verdict", "" if verdict is None else "; ".join([verdict["word"], *verdict["reasons"]])),
        *(("flagged", line) for line in flagged_lines(document["flags"], rate)),
        *(("note", note) for note in document["notes"]),
    ]
