"""A diagnosis in words: the verdict, the residual with each suspect, which are not distinguishable, what to record next."""

import math
from collections.abc import Sequence
from pathlib import Path

from identify.formatting import DASH, among, plain_name, three_figures
from identify.judging.verdict import MOST_RIVALS, headline_of
from identify.priors import CLEAR
from identify.residual import floor_words, residual_words, times, would_explain
from station.results.confirmation_document import PredictionErrors
from station.results.diagnosis_document import (
    DecidedDocument,
    DiagnosisDocument,
    FindingDocument,
    SharesDocument,
    SuspectDocument,
)
from station.results.documents import EstimateDocument
from station.story.engineering_values import Weighing
from station.suggestions import MEASURED_CURVE
from station.text.content import Paragraph, Part, Table, Told, Tone, facts
from station.text.numbers import amplitude_words, typeset, typeset_unit, with_names

TONES: dict[str, Tone] = {"nothing_missing": "good", "not_enough_data": "unsure"}
MOST_SUSPECTS, FEW_SUSPECTS = 6, 3
PREDICTED = ("motion", "phase", "envelope")
STRENGTH_UNKNOWN = "strength not determined"
_MOST_OF_IT = 0.5
"""Share of the residual that a free-form force must explain to be added as a measured curve."""

NO_NAME, BESIDE = "a law outside the library instead", "a law outside the library beside the first"
DECIDED = {
    "named": "The evidence suffices for a name",
    "would name": "This evidence would suffice, but another condition for a name is not met",
    "nothing": "No law of the library is better than a random walk",
    "no name": "No effect is named: the evidence does not single one out",
    "may drift": "No effect is named: a law of time is not distinguished from one of the amplitude",
    "too many": "Not decided: too many laws are not distinguishable",
    "leaves drift": "No effect is named, because a random walk remains above the noise",
}


def verdict_line(document: DiagnosisDocument) -> str:
    """Write the verdict in one line, a single name with what is plausible and not distinguishable from it."""
    undecided = bool(document.confirmation and document.confirmation.undecided)
    kinds = {one.effect: one.kind for one in document.suspects if one.plausible}
    return headline_of(document.verdict, document.named, document.rivals, kinds, undecided=undecided)


def headline(document: DiagnosisDocument) -> str:
    """Write the same as a headline, the verdict in capitals."""
    verdict, colon, names = verdict_line(document).partition(":")
    return f"{verdict.upper()}{colon}{names}"


def tone_of(document: DiagnosisDocument) -> Tone:
    """Decide how good a verdict is."""
    return TONES.get(document.verdict, "bad")


def told(document: DiagnosisDocument, weighing: Weighing, *, full: bool = False) -> Told:
    """Tell a diagnosis; `full` puts all suspects into the table, with the reason for each."""
    named, few = bool(document.named), FEW_SUSPECTS if document.named else FEW_SUSPECTS - 1
    brief: list[Part] = []
    if document.noise_floor is not None:
        brief.append(residuals(document, MOST_SUSPECTS if full else few, full=full))
    first, stop, _ = typeset(document.explanation).partition(". ")
    said = [("values", _values(document, weighing)), ("alike", not_distinguishable(document))]
    following = [("record next", typeset(document.next_experiment))]
    record = [] if named else following
    sensor = [("sensor", found_in_sensor(finding)) for finding in document.findings]
    mend = [("to mend it", finding.what_to_do) for finding in document.findings]
    brief += [] if named or full or not first else [Paragraph(first + stop.strip())]
    said.append(("caution", typeset(document.caution)))
    brief += facts((*said, *record, ("not shared", _not_shared(document)), *sensor[:1]))
    more: list[Part] = [Paragraph(typeset(document.explanation))]
    more += [evidence(one, stands=named) for one in document.decided]
    more += predictions(document)
    more += shares_tables(document.shares)
    rest = following if named else []
    more += facts((*_facts(document), *sensor[1:], *mend, *rest))
    return Told(headline(document), tone_of(document), tuple(brief), tuple(more))


def residuals(document: DiagnosisDocument, most: int = MOST_SUSPECTS, *, full: bool = False) -> Table:
    """Make the table of residuals: of the model, of the model with each suspect, in their order, and of noise alone.

    `full` adds the reason for which each is a suspect, and chi-square. What predictions name together was fitted together.
    """
    error, named = document.error, document.error_with_named
    predicted = document.by_prediction
    reason = ["predicts"] if predicted else ["explains"] * full
    rows = [("", document.model_is, error.motion_percent, error.chi2, "")]
    if named is not None and len(document.named) > 1:
        rows.append(("named", "+ all named effects", named.motion_percent, named.chi2, ""))
    for suspect in shown_suspects(document, most):
        after = suspect.error_after
        word = predicts(document, suspect) if predicted else would_explain(error.chi2, after)
        mark = "named" if suspect.effect in document.named else "" if suspect.claimed else "weak"
        together = predicted and mark == "named" and len(document.named) > 1
        motion, left = (None, None) if together else (suspect.motion_percent, after)
        rows.append((mark, f"+ {suspect.effect}", motion, left, word))
    cells = [
        (name, three_figures(motion), times(chi2), *[word] * bool(reason), *[three_figures(chi2)] * full)
        for _, name, motion, chi2, word in rows
    ]
    blank = ("",) * (len(reason) + full)
    cells.append(("noise alone", "", floor_words(error.chi2_std), *blank))
    head = (
        f"residual, free run of {three_figures(error.horizon_s)} s", "% of motion", "times noise", *reason,
        *["chi-square"] * full,
    )  # fmt: skip
    return Table("", head, tuple(cells), marks=(*(row[0] for row in rows), "noise"))


def predicts(document: DiagnosisDocument, suspect: SuspectDocument) -> str:
    """Say on how many of the parts that were left out a suspect predicts better, in a word or two; "-" if not asked."""
    found = document.confirmation
    if found is None or suspect.confirmed is None:
        return DASH
    effect = next((e for e in found.effects if e.name == suspect.effect), None)
    if effect is not None:
        return f"{effect.better} of {effect.parts}"
    if any(suspect.effect in names for names in found.undecided.values()):
        return "undecided"
    if suspect.effect in (*document.rivals, *(name for e in found.effects for name in e.rivals)):
        return "nearly"
    return "less likely" if found.effects else "no"


def evidence(decided: DecidedDocument, *, stands: bool) -> Table:
    """Make the table of what was weighed, and how far each is behind the first (nats); the caption says what was decided.

    It `stands` if the verdict names anything: the evidence of one of several effects, or of one curve, may not do.
    """
    weighed = {plain_name(name): nats for name, nats in decided.nats.items()} | {NO_NAME: decided.unnamed}
    ranked = sorted(
        ((name, nats) for name, nats in weighed.items() if nats is not None), key=lambda one: -one[1]
    )
    rows = [
        (name, three_figures(nats), three_figures(ranked[0][1] - nats))
        for name, nats in ranked[:MOST_SUSPECTS]
    ]
    if decided.beside is not None:
        rows.append((BESIDE, three_figures(decided.beside), ""))
    of = f" of {plain_name(*decided.nats)}" if len(decided.nats) == 1 else ""
    of = f" in the curve of {decided.explains}" if decided.explains else of
    word = "would name" if decided.verdict == "named" and not stands else decided.verdict
    caption = f"Evidence{of} beyond a random walk, in nats (natural log odds). {DECIDED[word]}"
    return Table(caption, ("law", "nats", "nats behind the first"), tuple(rows))


def predictions(document: DiagnosisDocument) -> tuple[Table, ...]:
    """Make the table of the prediction errors on each part that was left out; none where that was not asked."""
    found = document.confirmation
    if found is None or not document.by_prediction:
        return ()
    whole = "all but the large amplitudes" if found.one_record else "all, rms"
    each = zip(found.usual.by_part, found.found.by_part, strict=True)
    rows = [(before.part, before, after) for before, after in each] + [(whole, found.usual, found.found)]
    cells = tuple(
        (name, *(_predicted(before, after if found.effects else None, kind) for kind in PREDICTED))
        for name, before, after in rows
    )
    change = ", without and with the confirmed effects" if found.effects else ""
    caption = f"Prediction error on the parts that were not fitted, in % of the motion{change}"
    return (Table(caption, ("left out", *PREDICTED), cells),)


def _predicted(before: PredictionErrors, after: PredictionErrors | None, kind: str) -> str:
    values = [getattr(one, f"{kind}_percent") for one in (before, after) if one is not None]
    return " to ".join(map(three_figures, values))


def shown_suspects(document: DiagnosisDocument, most: int = MOST_SUSPECTS) -> list[SuspectDocument]:
    """Choose the suspects that are worth a line: what is named, the next ones, `most` in all, and the first two rivals."""
    claimed = sum(suspect.claimed for suspect in document.suspects)
    most = max(min(most, claimed), len(document.named), min(3, most))
    rivals = document.rivals[:MOST_RIVALS]
    return [s for rank, s in enumerate(document.suspects) if rank < most or s.effect in rivals]


def parameters(found: SuspectDocument, weighing: Weighing) -> str:
    """Write the values of a suspect, and of a sensor's fault the channel that it is in.

    Of one whose strength, the first, is not determined only others that differ clearly from zero.
    """
    values, unknown = weighing.weighed(found.effect, found.parameters), []
    if not found.strength_known:
        others = list(values.items())[1:]
        values = {k: v for k, v in others if abs(v.value or 0.0) > CLEAR * (v.std or math.inf)}
        unknown = [STRENGTH_UNKNOWN]
    channel = [f"in the {found.channel}"] if found.channel else []
    return "; ".join([*channel, *with_names(values), *unknown])


def _values(document: DiagnosisDocument, weighing: Weighing) -> str:
    """Write the values of what is named."""
    texts = []
    for suspect in document.suspects:
        if suspect.effect not in document.named:
            continue
        text = parameters(suspect, weighing)
        texts.append(f"{plain_name(suspect.effect)}: {text}" if len(document.named) > 1 else text)
    return "; ".join(texts)


def _not_shared(document: DiagnosisDocument) -> str:
    """Say by how much the values that each session has of its own are off those of all; "" where they share them."""
    own: dict[str, list[str]] = {}
    for one in document.of_sessions:
        off = "" if one.percent is None else f" {one.percent:+.3g} %"
        own.setdefault(one.parameter, []).append(f"{one.session}{off}")
    return "; ".join(f"{_of_effect(parameter)}: {', '.join(each)}" for parameter, each in own.items())


def _facts(document: DiagnosisDocument) -> list[tuple[str, str]]:
    """List the facts beside the verdict."""
    found = [
        ("model", " + ".join(plain_name(name) for name in document.model.effects)),
        ("", document.model_remark),
        ("together", ", ".join(document.sessions) if len(document.sessions) > 1 else ""),
        ("used", used(document)),
        ("other modes", " and ".join(mode["words"] for mode in document.modes)),
    ]
    left = [
        f"{'a run that diverges' if one.chi2 is None else residual_words(one.motion_percent, one.chi2)} in {one.session}"
        for one in document.held_out or ()
    ]
    found.append(("left out", f"fitted to the others, the model leaves {'; '.join(left)}" if left else ""))
    return found


def _of_effect(parameter: str) -> str:
    """Write "k of linear stiffness" for "linear_stiffness.k"."""
    effect, _, name = parameter.partition(".")
    return f"{name} of {plain_name(effect)}" if name else plain_name(effect)


def found_in_sensor(finding: FindingDocument, *, advice: bool = False) -> str:
    """Describe a sensor's fault that every fit corrects, in a clause; with `advice`, what to do about it."""
    where = f" in the {finding.channel}" if finding.channel else ""
    words = typeset(finding.words) or f"{finding.title}{where} ({', '.join(with_names(finding.parameters))})"
    return f"{words}; {finding.what_to_do}" if advice else words


def used(document: DiagnosisDocument) -> str:
    """Say which part of the record was analysed; of several the shares, and which end where readings are missing."""
    if len(document.used) < 2:
        return document.used[0].words if document.used else ""
    cut = [f"{one.session}: {one.words}" for one in document.used if one.ended == "readings_missing"]
    shares = [100.0 * (one.share or 0.0) for one in document.used]
    low, high = f"{min(shares):.0f}", f"{max(shares):.0f}"
    part = f"{low} to {high} %" if low != high else "all" if low == "100" else f"{low} %"
    return "; ".join([f"{part} of each record after its release", *cut])


def not_distinguishable(document: DiagnosisDocument) -> str:
    """Say which suspects explain the record as well as the one that is named; "" where none does."""
    if not document.rivals or not document.named:
        return ""
    rivals = among([plain_name(name) for name in document.rivals], "or")
    record = "this record" if len(document.sessions) < 2 else "these records"
    return f"{record} cannot distinguish {plain_name(document.named[0])} from {rivals}"


def shares_tables(shares: Sequence[SharesDocument]) -> tuple[Table, ...]:
    """Make a table for the largest and one for the smallest amplitude, an effect a row; none where nothing is known."""
    found = []
    for which, at in zip(("largest", "smallest"), shares, strict=False):
        rows = tuple(
            (one.effect, _cell(one.force), three_figures(one.force_percent.value), _cell(one.loss_percent),
             _cell(one.frequency_percent))
            for one in at.effects
        )  # fmt: skip
        size, force = amplitude_words(at.amplitude, at.unit), typeset_unit(at.effects[0].force.unit)
        head = (
            f"at {size},\nthe {which}", f"largest force\n{force}", "all but\nspring, %", "of the\nloss, %",
            "frequency\nchanged, %",
        )  # fmt: skip
        found.append(Table("", head, rows))
    return tuple(found)


def _cell(found: EstimateDocument) -> str:
    """Write three figures of a value, and its error rounded up to the same decimals."""
    number = three_figures(found.value)
    if not found.std or "×" in number:
        return number
    decimals = len(number.partition(".")[2])
    return f"{number} ± {math.ceil(found.std * 10**decimals) / 10**decimals:.{decimals}f}"


def next_command(document: DiagnosisDocument, folders: list[Path]) -> tuple[str | Path, ...]:
    """Choose the command that comes next: where nothing is decided, to diagnose this together with another release."""
    if document.named and document.verdict in ("missing_effect", "sensor_fault"):
        return ("refine", folders[0], *(word for name in document.named for word in ("--add", name)))
    shaped = document.shape is not None and document.shape.explained > _MOST_OF_IT
    if document.verdict == "unknown_effect" and shaped and MEASURED_CURVE not in document.model.effects:
        return ("refine", folders[0], "--add", MEASURED_CURVE)
    if document.verdict == "nothing_missing":
        return ("report", folders[0])
    return () if document.verdict == "not_enough_data" else ("diagnose", *folders, "ANOTHER_RELEASE")
