"""The section of the final equation: with letters, with numbers, and every parameter with its error and unit."""

import re
from collections.abc import Iterator

from identify.fitting.fit import Fit
from identify.formatting import SPACE, with_error
from station.report.findings import Findings
from station.story.engineering_values import Weighing
from station.story.measured_curves import measured_curves
from station.story.pipeline import Compared
from station.story.residual import residual_words
from station.text.content import Equation, Figure, Paragraph, Part, Table
from station.text.layout import sentence
from station.text.numbers import typeset, typeset_unit
from station.views.diagnosis_figures import measured_curve as draw_curve

FAR = 4.0
SEGMENTS = "the values are fitted to {} pieces of the record, which share the physics."

CURVE = (
    "{}, a spline of six coefficients, with 2 standard errors; the straight line in the {} belongs to spring and damper. "
    "It has no name: {} in the model file keeps it, and `station validate` tests it on other releases."
)


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
    lines = [_typeset_equation(f"{' + '.join(line)} = {right}") for line in (terms, _numbers(fit, weighing))]
    parts: list[Part] = [
        Paragraph(f"{sentence(compared.words)}", label="Model"),
        Equation(tuple(lines)),
        Paragraph(
            "Displacement u from the spring's zero and velocity v in "
            f"{compared.comparison.unit} and {compared.comparison.unit}/s"
            f"{weighing.words and f'; {weighing.words}'}."
        ),
        _parameters(fit, weighing),
    ]
    expressions = () if found.ladder is None else found.ladder.top.model.expressions
    for curve in measured_curves(fit, expressions):
        parts.append(Figure(CURVE.format(curve.title, curve.over, curve.name), draw_curve(curve, weighing)))
    if len(fit.windows) > 1:
        parts.append(Paragraph(SEGMENTS.format(len(fit.windows)), label="Long record"))
    doubt = caution(compared)
    if doubt:
        parts.append(Paragraph(doubt, label="Caution", strong=True))
    return parts


def caution(compared: Compared) -> str:
    """Say why the standard errors may be too small, or ""."""
    error = compared.error
    if error.chi_square <= 1.0 + FAR * error.floor_std:
        return ""
    return (
        f"This model leaves {residual_words(error.motion_percent, error.chi_square)}. The standard errors "
        "allow for a slow drift of the motion. A missing force may have moved the parameters by more."
    )


def _numbers(fit: Fit, weighing: Weighing) -> Iterator[str]:
    """Write the terms with the values in place of the mass and the parameters, rounded to their errors."""
    inertia, *forces = weighing.terms((term.effect for term in fit.model.terms), in_numbers=True)
    yield inertia
    for text, term in zip(forces, fit.model.forces, strict=True):
        for name, value in weighing.weighed(term.effect.name, fit.of(term, 0)).items():
            number = with_error(value.value, value.std).replace("(error unknown)", "").strip()
            number = re.sub(rf"{SPACE}±{SPACE}[^)]*", "", number).strip("(").replace(")", "")
            number = f"({number})" if "×" in number or number.startswith("-") else number
            text = re.sub(rf"(?<![\w']){re.escape(name)}(?![\w'])", lambda _, n=number: n, text)  # type: ignore[misc]
        yield text


def _typeset_equation(text: str) -> str:
    raised = re.sub(r"mu_(\d)", lambda found: typeset(found.group(0)), typeset(text))
    return raised.replace("u''", "ü", 1).replace("+ -", "− ")


def _parameters(fit: Fit, weighing: Weighing) -> Table:
    rows = []
    for term in fit.model.terms:
        meanings = {parameter.name: parameter.meaning for parameter in term.effect.parameters}
        for name, value in weighing.weighed(term.effect.name, fit.of(term, 0)).items():
            unit = typeset_unit(value.unit) or "1"
            number = with_error(value.value, value.std)
            rows.append((term.effect.name, typeset(name), weighing.worded(meanings[name]), number, unit))
    head = ("effect", "parameter", "meaning", "value", "unit")
    return Table("Parameters (± one standard error)", head, tuple(rows), texts=3)
