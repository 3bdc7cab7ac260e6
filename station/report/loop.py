"""The sections of the loop: the suspects with what is not distinguishable, and the ladder."""

from station.report.findings import Findings
from station.story.preparation import length_unit
from station.text import ladder_text
from station.text.content import Figure, Paragraph, Part, Table, facts
from station.text.curves_text import curves_caption
from station.text.diagnosis_text import parameters, shown_suspects, told
from station.text.numbers import typeset
from station.views import diagnosis_figures as draw


def suspects(found: Findings) -> list[Part]:
    """Show the verdict of the diagnosis, the suspects in order, and the forces that they would add; nothing without one."""
    document = found.diagnosis
    if document is None:
        return []
    words = told(document, full=True)
    parts: list[Part] = [Paragraph(typeset(document.explanation), label=words.headline, strong=True)]
    parts += words.brief
    meant = tuple((s.effect, s.title, parameters(s)) for s in shown_suspects(document))
    if meant:
        parts.append(Table("", ("effect", "what it is", "values"), meant, texts=3))
    if found.maps:
        caption = (
            "The force that the model lacks over the cycle (0°: farthest out), and what the best suspects would add. "
            "The right one looks like the first picture."
        )
        parts.append(Figure(caption, draw.force_maps(found.maps, length_unit(found.recording))))
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
            f"The missing force in free form; it explains {100 * shape.explained:.0f} % of the residual."
        )
        parts.append(Figure(caption, draw.shape(shape.curves[0])))
    known = document.suspects[0].confusable_with if document.named and document.suspects else []
    confused = f"{', '.join(known)}; a record of another kind separates them" if known else ""
    return [*parts, *words.more[1:], *facts([("easily confused", confused)])]


def ladder(found: Findings) -> list[Part]:
    """Show the residual from the first model to the current one, and the noise; nothing without a ladder."""
    if found.ladder is None:
        return []
    words = ladder_text.told(found.ladder)
    why = [Paragraph(words.headline)] if found.ladder.stopped_because else []
    return [*why, *words.brief, *words.more]
