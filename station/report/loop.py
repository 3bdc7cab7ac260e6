"""The sections of the loop: the suspects, the ladder, and what could not be told apart."""

from station.report import diagnosis_figures as draw
from station.report.content import Figure, Paragraph, Part, Section, Table, left_out
from station.report.findings import Findings
from station.results.diagnosis_document import DiagnosisDocument, FindingDocument, SuspectDocument
from station.story.residual import floor_words, times, would_explain
from station.text.curves_text import curves_caption
from station.text.diagnosis_text import (
    STRENGTH_UNKNOWN,
    confirmed_by,
    found_in_sensor,
    headline,
    not_distinguishable,
    predicts,
    shown_suspects,
    used,
)
from station.text.ladder_text import step_words
from station.text.layout import sentence
from station.text.numbers import (
    DASH,
    change,
    typeset,
    typeset_figures,
    typeset_symbol,
    typeset_with_unit,
)
from station.text.shares_text import WHICH, at_amplitude

SUSPECTS = "Suspects: which effect is missing"
LADDER = "The ladder: the error, step by step"
PREDICTED = ("motion_percent", "phase_percent", "envelope_percent")
MODELS = ("as it was", "with it")
APART = "What could not be told apart, and the next recording"


def suspects(found: Findings) -> Section:
    """Show the verdict of the diagnosis, the suspects in order, and the forces that they would add."""
    document = found.diagnosis
    if document is None:
        return Section("suspects", SUSPECTS, (left_out(found.left_out["suspects"]),))
    parts: list[Part] = [Paragraph(typeset(document.explanation), label=headline(document), strong=True)]
    if len(document.sessions) > 1:
        parts.append(Paragraph(", ".join(document.sessions), label="Diagnosed together"))
    if document.used:
        parts.append(Paragraph(sentence(used(document)), label="Used of the record"))
    if document.modes:
        seen = " and ".join(mode.words for mode in document.modes)
        parts.append(
            Paragraph(f"Beside the motion's, {seen}; one mode is followed here.", label="Other modes")
        )
    parts += _predicted(document)
    if document.suspects:
        rows = tuple(
            (
                suspect.effect,
                suspect.title,
                typeset_figures(suspect.motion_percent),
                times(suspect.error_after),
                *_reasons(document, suspect),
                _parameters(suspect),
            )
            for suspect in shown_suspects(document)
        )
        reasons = ("explains, of the mean square",) if document.confirmation is None else ("predicts better",)
        residual = ("residual [% of motion]", "residual / noise")
        head = ("effect", "what it is", *residual, *reasons, "parameters")
        parts.append(
            Table(f"Suspects in order, each added to {document.model_is}", head, rows, texts=2, wordy=True)
        )
        picture = draw.errors(document)
        if picture is not None:
            parts.append(Figure(f"Residual after adding each suspect to {document.model_is}.", picture))
    if found.fits is not None and found.fits.best:
        caption = (
            "The force that the model lacks over the cycle (0°: farthest out), and what the best suspects would add. "
            "The right one looks like the first picture."
        )
        parts.append(Figure(caption, draw.force_maps(found.fits)))
    elif "force_maps" in found.left_out:
        parts.append(Paragraph(f"The pictures of forces are left out: {found.left_out['force_maps']}."))
    if found.curves is not None:
        words = curves_caption(found.curves.names, found.curves.curves)
        parts.append(Figure(words, draw.curves(found.curves)))
    parts += _findings(document) + _shares(document)
    return Section("suspects", SUSPECTS, tuple(parts))


def _reasons(document: DiagnosisDocument, suspect: SuspectDocument) -> tuple[str, ...]:
    """Return why a suspect is one: by what it predicts where that was asked, else by what it would explain."""
    if document.confirmation is not None:
        return (predicts(document, suspect),)
    return (would_explain(document.error.chi2, suspect.error_after),)


def _predicted(document: DiagnosisDocument) -> list[Part]:
    """Show how well each release, or half of one, was predicted from the others."""
    found = document.confirmation
    if found is None or found.driven:
        return []
    parts: list[Part] = []
    words = confirmed_by(document)
    if words:
        parts.append(Paragraph(sentence(words), label="Confirmed"))
    whole = [] if found.one_record else [("median", found.usual, found.found)]
    each = [(u.part, u, f) for u, f in zip(found.usual.by_part, found.found.by_part, strict=True)]
    rows = tuple(
        (
            name,
            *(typeset_figures(getattr(errors, kind)) for kind in PREDICTED for errors in (usual, with_named)),
        )
        for name, usual, with_named in (*each, *whole)
    )
    head = (
        "left out",
        *(f"{kind.removesuffix('_percent')}, {model}" for kind in PREDICTED for model in MODELS),
    )
    caption = (
        "Error of the prediction of what was not fitted, in % of the motion: by the model that was asked about, and with "
        "what is confirmed"
    )
    parts.append(Table(caption, head, rows))
    return parts


def _parameters(suspect: SuspectDocument | FindingDocument) -> str:
    if isinstance(suspect, SuspectDocument) and not suspect.strength_known:
        return STRENGTH_UNKNOWN
    values = [
        f"{typeset_symbol(name)} = {typeset_with_unit(value)}" for name, value in suspect.parameters.items()
    ]
    where = [f"in the {suspect.channel}"] if suspect.channel else []
    return "; ".join([*where, *values])


def _findings(document: DiagnosisDocument) -> list[Part]:
    parts: list[Part] = []
    for finding in document.findings:
        text = f"{sentence(typeset(found_in_sensor(finding))).rstrip('.')}; {finding.what_to_do}."
        parts.append(Paragraph(text, label="Sensor"))
    shape = document.shape
    if shape is not None and shape.curves:
        caption = f"The free form of what has no name; it explains {100 * shape.explained:.0f} % of the rest."
        parts.append(Figure(caption, draw.shape(shape.curves[0])))
    return parts


def _shares(document: DiagnosisDocument) -> list[Part]:
    """Show what each effect of the model that was found does, at the largest and at the smallest amplitude."""
    rows = [
        (
            at_amplitude(which, at),
            one.effect,
            *(
                DASH if share.value is None else "0" if share.value == 0.0 else typeset_with_unit(share)
                for share in (one.force, one.force_percent, one.loss_percent, one.frequency_percent)
            ),
        )
        for which, at in zip(WHICH, document.shares, strict=False)
        for one in at.effects
    ]
    if not rows:
        return []
    caption = (
        "What each effect does over a cycle: its largest force, that in % of the largest of all forces but the linear "
        "spring's, its part of the energy that is lost, and by how much it raises the frequency"
    )
    head = ("amplitude", "effect", "largest force", "of all forces", "of the loss", "frequency")
    return [Table(caption, head, tuple(rows), texts=2)]


def ladder(found: Findings) -> Section:
    """Show the errors from the first model to the current one, and the floor."""
    if found.ladder is None:
        return Section("ladder", LADDER, (left_out(found.left_out["ladder"]),))
    kept = found.ladder
    rows: list[tuple[str, ...]] = []
    for place, step in enumerate(kept.steps[: kept.present + 1]):
        before = kept.steps[place - 1].error.times_noise if place else None
        error = step.error
        rows.append(
            (
                str(place), step_words(step), typeset_figures(error.motion_percent), times(error.chi2),
                change(before, error.times_noise) if place else "",
            )
        )  # fmt: skip
    floor = kept.floor
    rows.append(
        ("", "noise alone", typeset_figures(floor.motion_percent), floor_words(kept.top.chi2_std), "")
    )  # fmt: skip
    head = ("step", "effect", "residual [% of motion]", "residual / noise", "change")
    parts: list[Part] = [Table("The ladder", head, tuple(rows), texts=2)]
    picture = draw.steps(kept)
    if picture is not None:
        parts.append(Figure("The residual step by step (band: two standard errors of the floor).", picture))
    if kept.stopped_because:
        parts.append(Paragraph(sentence(kept.stopped_because)))
    return Section("ladder", LADDER, tuple(parts))


def apart(found: Findings) -> Section:
    """Say what this record cannot tell apart or determine, and what to record next."""
    parts: list[Part] = []
    document = found.diagnosis
    if document is not None:
        if document.rivals:
            parts.append(Paragraph(sentence(not_distinguishable(document)), label="Not told apart"))
        elif document.named:
            others = (
                "no other effect predicts it nearly as well."
                if document.confirmed
                else "every other suspect leaves clearly more than the one that was named."
            )
            parts.append(Paragraph(others, label="Told apart"))
        known = document.suspects[0].confusable_with if document.named and document.suspects else []
        if known:
            parts.append(
                Paragraph(
                    f"{', '.join(known)}; a record of another kind separates them.", label="Easily confused"
                )
            )
        parts.append(Paragraph(typeset(document.next_experiment), label="Record next", strong=True))
    else:
        parts.append(
            Paragraph(
                "No diagnosis was made, and so nothing is said about what else would explain this record."
            )
        )
    compared = found.compared
    if compared is not None and compared.baseline.fit.unidentifiable:
        names = ", ".join(compared.baseline.fit.unidentifiable)
        parts.append(Paragraph(names, label="Not determined by this record"))
    return Section("apart", APART, tuple(parts))
