"""The sections of the loop: the suspects with what is not distinguishable, and the ladder."""

from station.report.findings import Findings
from station.report.section import Section
from station.results.diagnosis_document import DiagnosisDocument
from station.text import ladder_text
from station.text.content import Facts, Figure, Paragraph, Part, Table, facts, left_out
from station.text.curves_text import curves_caption
from station.text.diagnosis_text import confirmed_by, headline, parameters, residuals, shown_suspects, told
from station.text.layout import sentence
from station.text.numbers import three_figures, typeset
from station.views import diagnosis_figures as draw

SUSPECTS = "Suspects: which effect is missing"
LADDER = "The ladder: the residual, step by step"
PREDICTED = ("motion_percent", "phase_percent", "envelope_percent")
MODELS = ("as it was", "with it")


def suspects(found: Findings) -> Section:
    """Show the verdict of the diagnosis, the suspects in order, and the forces that they would add."""
    document = found.diagnosis
    if document is None:
        return Section("suspects", SUSPECTS, (left_out(found.left_out["suspects"]),))
    words = told(document, full=True)
    verdict = Paragraph(typeset(document.explanation), label=headline(document), strong=True)
    parts: list[Part] = [verdict]
    parts += [part for part in words.brief if isinstance(part, Facts)]
    parts += _predicted(document)
    if document.noise_floor is not None:
        parts.append(residuals(document, full=True))
    meant = tuple((s.effect, s.title, parameters(s)) for s in shown_suspects(document))
    if meant:
        parts.append(Table("", ("effect", "what it is", "values"), meant, texts=3))
    if found.fits is not None and found.fits.best:
        caption = (
            "The force that the model lacks over the cycle (0°: farthest out), and what the best suspects would add. "
            "The right one looks like the first picture."
        )
        maps = [("what the model lacks", found.fits.missing_force())]
        maps += [(term.effect.name, added) for term, added in found.fits.added_forces()]
        parts.append(Figure(caption, draw.force_maps(maps, found.fits.prepared.window.unit)))
    elif "force_maps" in found.left_out:
        parts.append(Paragraph(f"The pictures of forces are left out: {found.left_out['force_maps']}."))
    if found.curves is not None:
        parts.append(
            Figure(
                curves_caption(found.curves.names, found.curves.curves),
                draw.curves(found.curves.curves, found.curves.names),
            )
        )
    shape = document.shape
    if shape is not None and shape.curves:
        caption = (
            f"The free form of what has no name; it explains {100 * shape.explained:.0f} % of the residual."
        )
        parts.append(Figure(caption, draw.shape(shape.curves[0])))
    known = document.suspects[0].confusable_with if document.named and document.suspects else []
    confused = f"{', '.join(known)}; a record of another kind separates them" if known else ""
    parts += [*words.more[1:], *facts([("easily confused", confused)])]
    return Section("suspects", SUSPECTS, tuple(parts))


def _predicted(document: DiagnosisDocument) -> list[Part]:
    """Show how well each release, or half of one, was predicted from the others."""
    found = document.confirmation
    if found is None or found.driven:
        return []
    parts: list[Part] = []
    words = confirmed_by(document)
    if words:
        parts.append(Paragraph(sentence(words), label="Confirmed"))
    whole = [] if found.one_record else [("all", found.usual, found.found)]
    each = [(u.part, u, f) for u, f in zip(found.usual.by_part, found.found.by_part, strict=True)]
    rows = tuple(
        (
            name,
            *(three_figures(getattr(errors, kind)) for kind in PREDICTED for errors in (usual, with_named)),
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


def ladder(found: Findings) -> Section:
    """Show the residual from the first model to the current one, and the noise."""
    if found.ladder is None:
        return Section("ladder", LADDER, (left_out(found.left_out["ladder"]),))
    words = ladder_text.told(found.ladder)
    why = [Paragraph(words.headline)] if found.ladder.stopped_because else []
    return Section("ladder", LADDER, (*why, *words.brief, *words.more))
