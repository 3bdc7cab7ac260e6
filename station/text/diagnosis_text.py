"""A diagnosis in one screenful of 80 columns: the verdict first, then why, the suspects, what to record next."""

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from identify.diagnosis.judgement import HEADLINES
from station.results.diagnosis_document import DiagnosisDocument, NoiseFloorDocument, SuspectDocument
from station.text.layout import labelled
from station.text.numbers import evidence, probability, three_figures, with_unit

STYLES = {"nothing_missing": "bold green", "not_enough_data": "bold yellow"}
MOST_SUSPECTS = 6
LABEL_WIDTH = 12


def headline(document: DiagnosisDocument) -> str:
    """Return the verdict in one line."""
    verdict = HEADLINES[document.verdict].upper()
    return f"{verdict}: {' and '.join(document.named)}" if document.named else verdict


def show_diagnosis(console: Console, document: DiagnosisDocument) -> None:
    """Print a diagnosis."""
    console.print()
    console.print(Text(f" {headline(document)}", style=STYLES.get(document.verdict, "bold red")))
    console.print()
    console.print(Padding(Text(document.explanation), (0, 1)))
    if document.suspects and document.noise_floor is not None:
        console.print()
        console.print(Padding(_errors(document, document.noise_floor), (0, 0, 0, 1)))
        console.print()
        console.print(Padding(_suspects(document), (0, 0, 0, 1)))
    console.print()
    for label, text in _facts(document):
        console.print(labelled(label, text, LABEL_WIDTH))
    console.print()


def _errors(document: DiagnosisDocument, floor: NoiseFloorDocument) -> Text:
    error = document.error
    return Text(
        f"model: {' + '.join(document.model.effects)}\n"
        f"leaves {three_figures(error.force_mse_percent)} % of the force, {three_figures(error.motion_percent)} % of "
        f"the motion over {error.horizon_s or 0.0:.1f} s,\n"
        f"and {three_figures(error.chi2)} times what noise explains (chi2; floor 1.00 ± {floor.chi2_std:.2f})"
    )


def _suspects(document: DiagnosisDocument) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("suspect", no_wrap=True)
    table.add_column("chi2\nafter", justify="right")
    table.add_column("evidence", justify="right", no_wrap=True)
    table.add_column("p", justify="right", no_wrap=True)
    table.add_column("with", overflow="fold")
    for rank, suspect in enumerate(shown_suspects(document)):
        style = "" if suspect.claimed else "dim"
        table.add_row(
            Text(suspect.effect, style=style),
            Text(three_figures(suspect.error_after), style=style),
            Text(evidence(suspect.evidence), style=style),
            Text(probability(suspect.p_value), style=style),
            Text(_parameters(suspect, None if rank == 0 else 1), style=style),
        )
    return table


def shown_suspects(document: DiagnosisDocument) -> list[SuspectDocument]:
    """Return the suspects that are worth a line: all that are claimed, at least three, and the rivals of the first."""
    claimed = sum(suspect.claimed for suspect in document.suspects)
    most = max(3, min(MOST_SUSPECTS, claimed))
    return [s for rank, s in enumerate(document.suspects) if rank < most or s.effect in document.rivals]


def _parameters(suspect: SuspectDocument, most: int | None) -> str:
    parts = [f"{name} {with_unit(value)}" for name, value in list(suspect.parameters.items())[:most]]
    where = f"in the {suspect.channel}" if suspect.channel else ""
    return "; ".join([*([where] if where else []), *parts])


def _facts(document: DiagnosisDocument) -> list[tuple[str, str]]:
    facts = []
    if document.rivals:
        facts.append(("the same", not_told_apart(document)))
    for finding in document.findings:
        where = f" in the {finding.channel}" if finding.channel else ""
        values = ", ".join(f"{name} {with_unit(value)}" for name, value in finding.parameters.items())
        facts.append(("sensor", f"{finding.title}{where} ({values}); {finding.what_to_do}"))
    shape = document.shape
    if shape is not None and shape.coordinates:
        over = " and ".join(shape.coordinates)
        facts.append(
            ("shape", f"a free-form force over {over} explains {100 * shape.explained:.0f} % of the rest")
        )
    if document.held_out:
        parts = [f"{one.session} {_left(one.chi2)}" for one in document.held_out]
        facts.append(("left out", f"physics of the others on each session, chi2: {', '.join(parts)}"))
    facts.append(("record next", document.next_experiment))
    return facts


def not_told_apart(document: DiagnosisDocument) -> str:
    """Return which suspects explain the record as well as the one that is named."""
    return f"this record does not tell {document.named[0]} from {', '.join(document.rivals)}"


def _left(chi_square: float | None) -> str:
    return "diverges" if chi_square is None else three_figures(chi_square)
