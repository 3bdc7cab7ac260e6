"""A validation in words: the verdict, then the prediction errors session by session."""

import math

from identify.fitting.validation import BASIS
from identify.formatting import plain_name, three_figures
from identify.residual import noise_multiple
from station.results.validation_document import ValidationDocument
from station.text.content import Table, Told, Tone, facts
from station.text.layout import sentence

TONES: dict[str, Tone] = {"predicts_better": "good", "no_better": "unsure", "predicts_worse": "bad"}


def told(document: ValidationDocument) -> Told:
    """Tell a validation."""
    others = [name for name in document.fitted_to if name != document.source]
    source = f"{document.source}, fitted to {', '.join(document.fitted_to)}" if others else document.source
    model = " + ".join(plain_name(name) for name in document.model.names)
    rows = [
        ("usual", sentence(BASIS[document.usual_from])),
        ("refitted", _refitted(document)),
        *(("skipped", f"{one.session}: {one.reason}") for one in document.skipped),
    ]
    before = facts((("model", model), ("from", source)))
    return Told(document.sentence, TONES[document.verdict], (*before, predictions(document), *facts(rows)))


def predictions(document: ValidationDocument) -> Table:
    """Make the table of the prediction errors of each session, by the usual model and by this one."""
    rows, marks = [], []
    for one in document.sessions:
        word = "better" if one.better else "worse" if one.worse else "alike"
        both = (one.usual, one.model)
        errors = (*(m.motion_percent for m in both), *(noise_multiple(m.chi2) for m in both))
        rows.append((one.session, word, *map(left, errors)))
        marks.append("noise" if one.better else "")
    head = ("session", "this one\nis", "% of motion,\nusual model", "\nthis model", "times noise,\nusual model",
            "\nthis model")  # fmt: skip
    return Table("", head, tuple(rows), texts=2, marks=tuple(marks))


def _refitted(document: ValidationDocument) -> str:
    """Say what was refitted, and by how much the linear spring and damper moved at most."""
    if document.held:
        return "Start, zero, lag, gain and offsets of each session; all physics was held."
    varied = [one.model.varied_percent for one in document.sessions]
    moved = [
        f"{name} by {max(abs(one.get(name) or 0.0) for one in varied):.2g} %"
        for name in dict.fromkeys(name for one in varied for name in one)
    ]
    most = f" (largest change: {', '.join(moved)})" if moved else ""
    return (
        "Start, zero, lag, gain and offsets of each session, and its linear spring and viscous damper, which are kept near "
        f"the model's{most}."
    )


def left(value: float | None) -> str:
    """Write what a model leaves, or that its run diverges."""
    return "diverges" if value is None or not math.isfinite(value) else three_figures(value)
