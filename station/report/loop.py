"""The sections of results: where the current model fails, suspects, ladder, equation of motion, both identifications."""

import re
from collections.abc import Iterator

from identify.fitting.fit import Fit
from identify.formatting import SPACE, with_error
from station.report.findings import Findings
from station.results.diagnosis_pictures import NamedCurves
from station.story.engineering_values import Weighing
from station.story.measured_curves import measured_curves
from station.story.pipeline import Compared
from station.text import comparison_text, diagnosis_text, identification_text, ladder_text
from station.text.content import Equation, Figure, Paragraph, Part, Table, facts, left_out
from station.text.layout import sentence
from station.text.numbers import typeset, typeset_unit, with_unit
from station.views import comparison_figures, diagnosis_figures, identification_figures
from station.views.overlay import alignment as picture_of_lag
from station.views.palette import LIGHT, Look

SEGMENTS = "the values are fitted to {} pieces of the record, which share the physics."

CAUTION = (
    "This model leaves {}. The standard errors allow for a slow drift of the motion. A missing force may have moved the "
    "parameters by more."
)
CURVE = (
    "{}, a spline of six coefficients, with 2 standard errors; the straight line in the {} belongs to spring and damper. "
    "It is no effect of the library: {} in the model file keeps it, and `station validate` tests it on other releases."
)


def comparison(found: Findings) -> tuple[Part, ...]:
    """Say and draw where the current model fails; nothing without one."""
    if found.compared is None:
        return ()
    headline = comparison_text.told(found.compared).headline
    return (Paragraph(headline, strong=True), *where_it_fails(found.compared))


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
    return [*parts, *words.more[1:]]


def ladder(found: Findings) -> list[Part]:
    """Show the residual from the first model to the current one, and the noise; nothing without a ladder."""
    if found.ladder is None:
        return []
    words = ladder_text.told(found.ladder, found.weighing)
    why = [Paragraph(words.headline)] if found.ladder.stopped_because else []
    return [*why, *words.brief, *words.more]


def curves_of(found: NamedCurves, look: Look = LIGHT) -> Figure:
    """Draw the curves of sessions with the laws of their diagnosis, and explain points, bands and lines."""
    names, curves = found
    many = len(curves.releases) > 1
    kept = [names[curve.release] for curve in curves.releases]
    whose = f"each of {len(kept)} releases ({', '.join(kept)})" if many else "this release"
    words = [
        f"How frequency and damping of {whose} change as the oscillation dies down. Each point is one stretch of the decay, "
        "a cycle or more; its band is two standard errors, from the scatter of its neighbours. The damping ratio is that of "
        "a viscous damper with the same loss: each cycle loses 4π times this ratio of the energy. A linear spring "
        "with viscous damping gives two level lines."
    ]
    if any(laid.curves for laid in curves.laws):
        words.append(
            "Thin line: the usual model, as it is fitted. Thick line: the model with the named effects, "
            "simulated and evaluated in the same way. Broken line: an effect that explains nearly as much."
        )
        if many:
            words.append("Every line has the linear stiffness and viscous damping of its own release.")
    left = [name for place, name in enumerate(names) if place not in {c.release for c in curves.releases}]
    if left:
        words.append(f"Too short for a curve: {', '.join(left)}.")
    return Figure(" ".join(words), diagnosis_figures.curves(curves, names, look))


def equation(found: Findings) -> list[Part]:
    """Show the current model in letters and in numbers; nothing without one."""
    compared = found.compared
    if compared is None:
        return []
    judged = compared.judged
    fit = judged.stated(judged.fit)
    weighing = found.weighing
    right = "0" if fit.windows[0].force is None else "f(t)" if weighing.mass else "f(t)/m"
    terms = weighing.terms(term.effect for term in fit.model.terms)
    sides = (typeset(f"{' + '.join(line)} = {right}") for line in (terms, _numbers(fit, weighing)))
    lines = tuple(side.replace("u''", "ü", 1).replace("+ -", "− ") for side in sides)
    parts: list[Part] = [
        Paragraph(f"{sentence(compared.words)}", label="Model"),
        Equation(lines),
        Paragraph(
            "Displacement u from the spring's zero and velocity v in "
            f"{compared.comparison.unit} and {compared.comparison.unit}/s"
            f"{weighing.words and f'; {weighing.words}'}."
        ),
        _parameters(fit, weighing),
    ]
    expressions = () if found.ladder is None else found.ladder.top.model.expressions
    for curve in measured_curves(fit, expressions):
        parts.append(
            Figure(
                CURVE.format(curve.title, curve.over, curve.name),
                diagnosis_figures.measured_curve(curve, weighing),
            )
        )
    if len(fit.windows) > 1:
        parts.append(Paragraph(SEGMENTS.format(len(fit.windows)), label="Long record"))
    if not judged.at_floor:
        parts.append(Paragraph(CAUTION.format(compared.left), label="Caution", strong=True))
    return parts


def _numbers(fit: Fit, weighing: Weighing) -> Iterator[str]:
    """Write the terms with the values in place of the mass and the parameters, rounded to their errors."""
    inertia, *forces = weighing.terms((term.effect for term in fit.model.terms), in_numbers=True)
    yield inertia
    for text, term in zip(forces, fit.model.forces, strict=True):
        for name, value in weighing.weighed(term.effect.name, fit.quoted(term, 0)).items():
            number = with_error(value.value, value.std).partition(" (error")[0]
            number = re.sub(rf"{SPACE}±{SPACE}[^)]*", "", number).strip("(").replace(")", "")
            number = f"({number})" if "×" in number or number.startswith("-") else number
            text = re.sub(rf"(?<![\w']){re.escape(name)}(?![\w'])", lambda _, n=number: n, text)  # type: ignore[misc]
        yield text


def _parameters(fit: Fit, weighing: Weighing) -> Table:
    rows = []
    for term in fit.model.terms:
        meanings = {parameter.name: parameter.meaning for parameter in term.effect.parameters}
        for name, value in weighing.weighed(term.effect.name, fit.quoted(term, 0)).items():
            unit = typeset_unit(value.unit) or "1"
            number = with_error(value.value, value.std)
            rows.append((term.effect.name, typeset(name), weighing.worded(meanings[name]), number, unit))
    head = ("effect", "parameter", "meaning", "value", "unit")
    return Table("Parameters (± one standard error)", head, tuple(rows), texts=3)


def methods(found: Findings) -> list[Part]:
    """Put both methods side by side; what was refused says why. Nothing where nothing was identified."""
    result = found.identification
    if result is None:
        return []
    words = identification_text.told("This release", result, full=True)
    parts = [Paragraph(words.headline, strong=True), *words.brief]
    if (lag := picture_of_lag(result)) is not None:
        caption = "Both channels as accelerations under one filter, close to a zero, where a lag shows most."
        parts.append(Figure(caption, lag))
    if not result.methods:
        return parts
    force, length = result.restoring_force, result.decay.unit
    if force is not None:
        constant = with_unit(result.weighing.strength(force.offset))
        parts += facts([("force from", f"{force.source}; constant {result.weighing.worded()} {constant}")])
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
