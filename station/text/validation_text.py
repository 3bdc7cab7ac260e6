"""A validation in one screenful of 80 columns: the verdict, then the errors of prediction session by session."""

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from identify.fitting.validation import BASIS
from identify.formatting import plain_name
from station.results.validation_document import PredictionDocument, ValidationDocument
from station.story.residual import noise_multiple
from station.text.layout import labelled, sentence
from station.text.numbers import three_figures

STYLES = {"predicts_better": "bold green", "no_better": "bold yellow", "predicts_worse": "bold red"}
LABEL_WIDTH = 9
MOST_ROWS = 40


def show_validation(console: Console, document: ValidationDocument) -> None:
    """Print a validation."""
    console.print()
    console.print(Padding(Text(document.sentence, style=STYLES[document.verdict]), (0, 1)))
    console.print()
    console.print(
        labelled("model", " + ".join(plain_name(name) for name in document.model.names), LABEL_WIDTH)
    )
    console.print(labelled("from", _source(document), LABEL_WIDTH))
    console.print()
    console.print(Padding(_table(document), (0, 0, 0, 1)))
    console.print()
    for label, text in _facts(document):
        console.print(labelled(label, text, LABEL_WIDTH))
    console.print()


def _source(document: ValidationDocument) -> str:
    others = [name for name in document.fitted_to if name != document.source]
    return f"{document.source}, fitted to {', '.join(document.fitted_to)}" if others else document.source


def _table(document: ValidationDocument) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("session", overflow="fold", max_width=30)
    for head in ("% of motion\nusual", "% of motion\nmodel", "times noise\nusual", "times noise\nmodel"):
        table.add_column(head, justify="right")
    table.add_column("the model\nis")
    for one in document.sessions[:MOST_ROWS]:
        word = "better" if one.better else "worse" if one.worse else "alike"
        style = "green" if one.better else "red" if one.worse else ""
        table.add_row(
            Text(one.session),
            *(_left(found.motion_percent) for found in (one.usual, one.model)),
            *(
                _left(None if found.chi2 is None else noise_multiple(found.chi2))
                for found in (one.usual, one.model)
            ),
            Text(word, style=style),
        )
    return table


def _facts(document: ValidationDocument) -> list[tuple[str, str]]:
    facts = []
    if len(document.sessions) > MOST_ROWS:
        facts.append(("more", f"{len(document.sessions) - MOST_ROWS} sessions are in --json"))
    facts.append(("usual", sentence(BASIS[document.usual_from])))
    facts.append(("refitted", _refitted(document)))
    facts += [("skipped", f"{one.session}: {one.reason}") for one in document.skipped]
    return facts


def _refitted(document: ValidationDocument) -> str:
    """Return what was refitted, and by how much the linear spring and damper moved at most."""
    if document.held:
        return "Start, zero, lag, gain and offsets of each session; all physics was held."
    return (
        "Start, zero, lag, gain and offsets of each session; linear spring and viscous part with priors of 1 % and of "
        f"100 % of the mean loss{_most([one.model for one in document.sessions])}."
    )


def _most(found: list[PredictionDocument]) -> str:
    """Return by how much the model's own were changed at most."""
    parts = []
    for name in dict.fromkeys(name for one in found for name in one.varied_percent):
        moved = max(abs(one.varied_percent.get(name) or 0.0) for one in found)
        parts.append(f"{name} by {moved:.2g} %")
    return f" (changed at most: {', '.join(parts)})" if parts else ""


def _left(value: float | None) -> str:
    return "diverges" if value is None else three_figures(value)
