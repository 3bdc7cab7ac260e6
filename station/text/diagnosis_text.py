"""A diagnosis in one screenful of 80 columns: the verdict first, then why, the suspects, what to record next."""

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from identify.diagnosis.verdict import HEADLINES
from identify.formatting import among, plain_name
from station.results.confirmation_document import ConfirmationDocument
from station.results.diagnosis_document import (
    DiagnosisDocument,
    FindingDocument,
    HeldOutDocument,
    NoiseFloorDocument,
    SuspectDocument,
)
from station.story.engineering_values import Weighing
from station.story.residual import floor_words, residual_words, times
from station.text.layout import labelled
from station.text.numbers import DASH, three_figures, with_names, with_unit
from station.text.shares_text import shares_table

STYLES = {"nothing_missing": "bold green", "not_enough_data": "bold yellow"}
MOST_SUSPECTS, FEW_SUSPECTS = 6, 3
STRENGTH_UNKNOWN = "strength not determined"
LABEL_WIDTH = 12


def headline(document: DiagnosisDocument) -> str:
    """Return the verdict in one line."""
    verdict = HEADLINES[document.verdict].upper()
    return f"{verdict}: {among([plain_name(name) for name in document.named])}" if document.named else verdict


def show_diagnosis(
    console: Console, document: DiagnosisDocument, weighing: Weighing | None = None, *, full: bool = False
) -> None:
    """Print a diagnosis: the verdict, what each model leaves, what to record next; `full` adds all else that is known.

    With a `weighing` the strengths of what is named stand in N, kg and s too.
    """
    console.print()
    console.print(Text(f" {headline(document)}", style=STYLES.get(document.verdict, "bold red")))
    if full or not document.named:
        console.print()
        console.print(Padding(Text(document.explanation), (0, 1)))
    if document.noise_floor is not None:
        console.print()
        console.print(Padding(_residuals(document, document.noise_floor, full), (0, 0, 0, 1)))
    if full and document.shares:
        console.print()
        console.print(Padding(shares_table(document.shares), (0, 0, 0, 1)))
    console.print()
    for label, text in (*_values(document, weighing, full), *_facts(document, full)):
        console.print(labelled(label, text, LABEL_WIDTH))
    console.print()


def _residuals(document: DiagnosisDocument, floor: NoiseFloorDocument, full: bool) -> Table:
    """Return what the model leaves, what it leaves with each suspect, in their order, and what noise alone leaves."""
    predicted = document.confirmation is not None
    error, named = document.error, document.error_with_named
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column(f"residual of a free run\nover {error.horizon_s or 0.0:.1f} s", overflow="fold")
    for head in ("% of the\nmotion", "times the\nnoise", *["predicts"] * predicted, *["chi-\nsquare"] * full):
        table.add_column(head, justify="right", no_wrap=True)
    rows = [(document.model_is, error.motion_percent, error.chi2, "", "")]
    if named is not None and len(document.named) > 1:
        rows.append(("+ all that is named", named.motion_percent, named.chi2, "", ""))
    rows += [
        (f"+ {s.effect}", s.motion_percent, s.error_after, predicts(document, s), "" if s.claimed else "dim")
        for s in shown_suspects(document, MOST_SUSPECTS if full else FEW_SUSPECTS)
    ]
    for name, motion, chi2, word, style in rows:
        cells = [name, three_figures(motion), times(chi2), *[word] * predicted, *[three_figures(chi2)] * full]
        table.add_row(*(Text(cell, style=style) for cell in cells))
    table.add_row(Text("noise alone"), "", Text(floor_words(floor.chi2_std)), style="green")
    return table


def predicts(document: DiagnosisDocument, suspect: SuspectDocument) -> str:
    """Return on how many of the parts that were left out a suspect predicts better, in a word or two; "-" if not asked."""
    found = document.confirmation
    if found is None or suspect.confirmed is None:
        return DASH
    effect = next((e for e in found.effects if e.name == suspect.effect), None)
    if effect is not None:
        return f"{effect.better} of {effect.parts}"
    if any(suspect.effect in e.rivals for e in found.effects):
        return "nearly"
    return "undecided" if any(suspect.effect in names for names in found.undecided.values()) else "no"


def confirmed_by(document: DiagnosisDocument) -> str:
    """Return on how many other releases, or parts of the record, what is named is confirmed, and its error; "" if none."""
    found = document.confirmation
    if found is None or not document.confirmed:
        return ""
    where = "parts of the record, each predicted from the rest" if found.one_record else "other releases"
    what = "all but the large amplitudes" if found.one_record else "the prediction"
    before, after = found.usual.motion_percent, found.found.motion_percent
    return (
        f"confirmed on {found.better} of {found.parts} {where}: error of {what} {three_figures(before)} to "
        f"{three_figures(after)} % of the motion"
    )


def predicted_parts(document: DiagnosisDocument) -> str:
    """Return the error of the prediction on each part that was left out, in % of the motion; "" where it was not asked."""
    found = document.confirmation
    if found is None or found.driven:
        return ""
    parts = []
    for before, after in zip(found.usual.by_part, found.found.by_part, strict=True):
        change = f" to {three_figures(after.motion_percent)}" if found.effects else ""
        parts.append(f"{before.part} {three_figures(before.motion_percent)}{change} %")
    what = "each part of the amplitudes from the rest" if found.one_record else "each release from the others"
    return f"{what}, error in % of the motion: {', '.join(parts)} ({_medians(found)})"


def _medians(found: ConfirmationDocument) -> str:
    """Return the errors of phase and envelope: their medians, or those of all but the large amplitudes of one record."""
    parts = []
    for name, before, after in (
        ("phase", found.usual.phase_percent, found.found.phase_percent),
        ("envelope", found.usual.envelope_percent, found.found.envelope_percent),
    ):
        change = f" to {three_figures(after)}" if found.effects else ""
        parts.append(f"{name} {three_figures(before)}{change} %")
    return f"{'of these' if found.one_record else 'median'}: {', '.join(parts)}"


def shown_suspects(document: DiagnosisDocument, most: int = MOST_SUSPECTS) -> list[SuspectDocument]:
    """Return the suspects that are worth a line: what is named, its rivals, and the next that are claimed, `most` in all."""
    claimed = sum(suspect.claimed for suspect in document.suspects)
    most = max(min(most, claimed), len(document.named), min(3, most))
    return [s for rank, s in enumerate(document.suspects) if rank < most or s.effect in document.rivals]


def _parameters(suspect: SuspectDocument) -> str:
    parts = with_names(suspect.parameters) if suspect.strength_known else [STRENGTH_UNKNOWN]
    where = f"in the {suspect.channel}" if suspect.channel else ""
    return "; ".join([*([where] if where else []), *parts])


def _values(document: DiagnosisDocument, weighing: Weighing | None, full: bool) -> list[tuple[str, str]]:
    """Return the values of what is named (`full`: of all suspects shown), the strength with the mass in it after them."""
    lines = []
    for suspect in shown_suspects(document):
        if not full and suspect.effect not in document.named:
            continue
        text = f"{plain_name(suspect.effect)}: {_parameters(suspect)}"
        name, value = next(iter(suspect.parameters.items()), (None, None))
        whole = None
        if weighing and suspect.strength_known and value is not None and value.value is not None:
            whole = weighing.strength(suspect.effect, value.value, value.std, value.unit)
        if whole is not None and weighing:
            text += f"; with a mass of {weighing.mass:g} kg {name} = {with_unit(whole)}"
        lines.append(("values", text))
    return lines


def _not_shared(document: DiagnosisDocument) -> list[tuple[str, str]]:
    """Return in what sessions differ from the first: what each then has of its own, and what one model has to fit."""
    own = {one.parameter for one in document.of_sessions}
    facts = []
    for is_own, what in ((True, "each has its own"), (False, "one model has to fit both")):
        differ = [
            f"{one.session} in {_of_effect(one.parameter)}{_by(one.percent)}"
            for one in document.differences or ()
            if (one.parameter in own) == is_own
        ]
        if differ:
            facts.append(("not shared", f"{', '.join(differ)}, against {document.sessions[0]}: {what}"))
    return facts


def _facts(document: DiagnosisDocument, full: bool) -> list[tuple[str, str]]:
    facts = []
    if full:
        facts.append(("model", " + ".join(plain_name(name) for name in document.model.effects)))
    if full and document.used:
        facts.append(("used", used(document)))
    if document.model_remark:
        facts.append(("model", document.model_remark))
    if document.differences:
        facts += _not_shared(document)
    if document.modes:
        seen = " and ".join(mode.words for mode in document.modes)
        facts.append(("modes", f"beside the motion's, {seen}; one mode is followed here"))
    predicted = predicted_parts(document) if full else ""
    if predicted:
        facts.append(("predicted", predicted))
    if document.rivals:
        facts.append(("the same", not_distinguishable(document)))
    facts += [
        ("sensor", f"{found_in_sensor(finding)}; {finding.what_to_do}") for finding in document.findings
    ]
    shape = document.shape
    if shape is not None and shape.coordinates:
        over = " and ".join(shape.coordinates)
        facts.append(
            ("shape", f"a free-form force over {over} explains {100 * shape.explained:.0f} % of the rest")
        )
    if document.held_out:
        parts = [f"{one.session} {_left(one)}" for one in document.held_out]
        facts.append(("left out", f"fitted to the others, the model leaves in {', '.join(parts)}"))
    facts.append(("record next", document.next_experiment))
    return facts


def _of_effect(parameter: str) -> str:
    """Return "k of linear stiffness" for "linear_stiffness.k"."""
    effect, _, name = parameter.partition(".")
    return f"{name} of {plain_name(effect)}" if name else plain_name(effect)


def found_in_sensor(finding: FindingDocument) -> str:
    """Return what was found of a sensor's fault that every fit corrects, in a clause."""
    if finding.words:
        return finding.words
    where = f" in the {finding.channel}" if finding.channel else ""
    values = ", ".join(with_names(finding.parameters))
    return f"{finding.title}{where} ({values})"


def _by(percent: float | None) -> str:
    return "" if percent is None else f" by {percent:+.3g} %"


def used(document: DiagnosisDocument) -> str:
    """Return which part of the record was analysed; of several the shares, and which end where readings are missing."""
    if len(document.used) == 1:
        return document.used[0].words
    cut = [f"{one.session}: {one.words}" for one in document.used if one.ended == "readings_missing"]
    shares = [100.0 * (one.share or 0.0) for one in document.used]
    low, high = f"{min(shares):.0f}", f"{max(shares):.0f}"
    part = f"{low} to {high} %" if low != high else "all" if low == "100" else f"{low} %"
    whole = f"{part} of each record after its release"
    return "; ".join([whole, *cut])


def not_distinguishable(document: DiagnosisDocument) -> str:
    """Return which suspects explain the record as well as the one that is named."""
    records = "this record does" if len(document.sessions) < 2 else "these records do"
    rivals = among([plain_name(name) for name in document.rivals], "or")
    return f"{records} not tell {plain_name(document.named[0])} from {rivals}"


def _left(one: HeldOutDocument) -> str:
    if one.chi2 is None:
        return "a run that diverges"
    return residual_words(one.motion_percent, one.chi2)
