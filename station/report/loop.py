"""The sections of results: where the current model fails, the suspects, the ladder, and both identifications."""

from collections.abc import Sequence

from identify.curves.laid_over import DecayCurves
from station.report.findings import Findings
from station.results.diagnosis_pictures import NamedCurves
from station.story.pipeline import Compared
from station.text import comparison_text, diagnosis_text, identification_text, ladder_text
from station.text.content import Figure, Paragraph, Part, Table, facts, left_out
from station.text.numbers import typeset, with_unit
from station.views import comparison_figures, diagnosis_figures, identification_figures
from station.views.palette import LIGHT, Look


def comparison(found: Findings) -> tuple[Part, ...]:
    """Say and draw where the current model fails; nothing without one."""
    return () if found.compared is None else where_it_fails(found.compared)


def where_it_fails(compared: Compared, look: Look = LIGHT) -> tuple[Part, ...]:
    """Say and draw where a model fails, in the colours of a look."""
    words = comparison_text.told(compared)
    figures = (
        Figure(
            "The force that the model lacks over the phase plane (+ and −: beyond 3 standard errors), and its "
            "sections with 2 standard errors.",
            comparison_figures.phase_plane(compared.comparison, look),
        ),
        Figure(
            "Measured less model, cycle by cycle, with 2 standard errors.",
            comparison_figures.cycles(compared.comparison, look),
        ),
    )
    return (*words.brief, *words.more, *figures)


def suspects(found: Findings) -> list[Part]:
    """Show the verdict of the diagnosis, the suspects in order, and the forces that they would add; nothing without one."""
    document = found.diagnosis
    if document is None:
        return []
    words = diagnosis_text.told(document, found.weighing, full=True)
    parts: list[Part] = [Paragraph(typeset(document.explanation), label=words.headline, strong=True)]
    if found.compared is not None and not document.is_of(found.compared.baseline.fit.model.names):
        parts.insert(0, Paragraph(f"This is the diagnosis of {document.model_is}, not of the current one."))
    parts += words.brief
    meant = tuple(
        (s.effect, s.title, diagnosis_text.parameters(s, found.weighing))
        for s in diagnosis_text.shown_suspects(document)
    )
    if meant:
        parts.append(Table("", ("effect", "what it is", "values"), meant, texts=3))
    if found.maps:
        caption = (
            "The force that the model lacks over the cycle (0°: farthest out), and what the best suspects would add. "
            "The right one looks like the first picture."
        )
        parts.append(Figure(caption, diagnosis_figures.force_maps(found.maps, found.weighing)))
    elif "force_maps" in found.left_out:
        parts.append(left_out(found.left_out["force_maps"], "The pictures of forces"))
    if found.curves is not None:
        parts.append(curves_of(found.curves))
    shape = document.shape
    if shape is not None and shape.curves:
        caption = (
            f"The missing force in free form; it explains {100 * shape.explained:.0f} % of the residual."
        )
        parts.append(Figure(caption, diagnosis_figures.shape(shape.curves[0], found.weighing)))
    known = document.suspects[0].confusable_with if document.named and document.suspects else []
    confused = f"{', '.join(known)}; a record of another kind separates them" if known else ""
    return [*parts, *words.more[1:], *facts([("easily confused", confused)])]


def ladder(found: Findings) -> list[Part]:
    """Show the residual from the first model to the current one, and the noise; nothing without a ladder."""
    if found.ladder is None:
        return []
    words = ladder_text.told(found.ladder, found.weighing)
    why = [Paragraph(words.headline)] if found.ladder.stopped_because else []
    return [*why, *words.brief, *words.more]


def curves_of(found: NamedCurves, look: Look = LIGHT) -> Figure:
    """Draw the curves of sessions with the laws of their diagnosis."""
    caption = curves_caption(found.names, found.curves)
    return Figure(caption, diagnosis_figures.curves(found.curves, found.names, look))


def curves_caption(names: Sequence[str], found: DecayCurves) -> str:
    """Explain points, bands and lines of the curves; `names` are those of the releases that were given."""
    many = len(found.releases) > 1
    kept = [names[curve.release] for curve in found.releases]
    whose = f"each of {len(kept)} releases ({', '.join(kept)})" if many else "this release"
    words = [
        f"How frequency and damping of {whose} change as the oscillation dies down. Each point is one stretch of the decay, "
        "a cycle or more; its band is two standard errors, from the scatter of its neighbours. The damping ratio is that of "
        "a viscous damper with the same loss: each cycle loses 4π times this ratio of the energy. A linear spring "
        "with viscous damping gives two level lines."
    ]
    if any(laid.curves for laid in found.laws):
        words.append(
            "Thin line: the usual model, as it is fitted. Thick line: the model with the named effects, "
            "simulated and evaluated in the same way. Broken line: an effect that explains nearly as much."
        )
        if many:
            words.append("Every line has the linear stiffness and viscous damping of its own release.")
    left = [name for place, name in enumerate(names) if place not in {c.release for c in found.releases}]
    if left:
        words.append(f"Too short for a curve: {', '.join(left)}.")
    return " ".join(words)


def methods(found: Findings) -> list[Part]:
    """Put both methods side by side; what was refused says why. Nothing where nothing was identified."""
    result = found.identification
    if result is None:
        return []
    why = facts(identification_text.reasons(result))
    if not result.methods:
        return [*why]
    words = Paragraph(identification_text.told("This release", result).headline, strong=True)
    force, length = result.restoring_force, result.decay.unit
    offset = ""
    if force is not None:
        constant = with_unit(result.weighing.strength(force.offset))
        offset = f"{force.source}; constant {result.weighing.worded()} {constant}"
    parts: list[Part] = [
        words,
        identification_text.methods_table(result, full=True),
        *why,
        *facts([("force from", offset)]),
    ]
    if result.wavelet is not None:
        caption = (
            "Envelope on the ridge with its fit, instantaneous frequency (where it can be trusted), and backbone. "
            "A frequency that stays level means a linear stiffness."
        )
        parts.append(
            Figure(caption, identification_figures.envelope(result.wavelet, length, result.release.time_s))
        )
    caption = (
        "Residual against the order of damping (circle: the order chosen), and significance of the terms."
    )
    parts.append(Figure(caption, identification_figures.orders(result)))
    if force is not None:
        parts.append(
            Figure(
                "Sections of the restoring force surface.",
                identification_figures.sections(force, result.weighing),
            )
        )
    return parts
