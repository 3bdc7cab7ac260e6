"""The result on the first page: values that may be quoted, of the model that explains the record, and what does not."""

from dataclasses import dataclass

from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.formatting import plain_name
from station.report.equation import caution
from station.report.findings import Findings
from station.story.adequacy import judgement, scale_doubt
from station.story.engineering_values import EngineeringValue, engineering_values
from station.story.residual import floor_words, residual_words
from station.text.diagnosis_text import confirmed_by, headline
from station.text.layout import sentence
from station.text.numbers import SPACE, typeset_error, typeset_unit

Rows = list[tuple[str, str]]


@dataclass(frozen=True, eq=False)
class Explaining:
    """The model that explains the record: which one it is, its fit, and what it leaves, in words."""

    words: str
    fit: Fit
    left: str


def summary(found: Findings) -> tuple[tuple[str, str], ...]:
    """Return labels and sentences, most important first."""
    model = explaining(found)
    rows: Rows = []
    if model is not None:
        rows.append(("model", f"{model.words}, {_names(model.fit)}: {model.left}"))
        rows += values(model.fit, found)
        aligned = None if found.identification is None else found.identification.alignment
        doubt = "" if aligned is None else scale_doubt(aligned.gain)
        rows += [("scale", doubt)] if doubt else []
    else:
        rows.append(("no value to quote", _nothing_explains(found)))
    rows += _others(found, model)
    if found.diagnosis is not None:
        rows.append(("diagnosis", f"{headline(found.diagnosis)} (in {found.diagnosis.model_is})"))
        confirmed = confirmed_by(found.diagnosis)
        if confirmed:
            rows.append(("prediction", sentence(confirmed)))
    if found.compared is not None:
        doubt = caution(found.compared)
        rows.append(("adequacy", doubt or "The model explains the measurement within its noise."))
    return tuple(rows)


def explaining(found: Findings) -> Explaining | None:
    """Return the model that explains the record: the current one, else that which was identified; None without."""
    current, adequate = found.compared, None
    if found.identification is not None:
        adequate = found.identification.adequacy
    if adequate is not None and adequate.doubt:
        return None
    if current is not None and current.judged.at_floor:
        judged, error = current.judged, current.error
        left = f"leaves {residual_words(error.motion_percent, error.chi_square)}{_floor(error.floor_std)}"
        return Explaining(current.words, judged.stated(judged.fit), left)
    if adequate is not None and adequate.adequate:
        left = f"leaves {residual_words(adequate.motion_percent, adequate.chi_square)}{_floor(adequate.chi_square_std)}"
        return Explaining("the identified model", adequate.fit, left)
    return None


def values(fit: Fit, found: Findings) -> Rows:
    """Return what a test report quotes of a fit, each with its error, its unit and, beside it, the same per unit mass."""
    return [
        (one.name, _with_per_mass(one))
        for one in engineering_values(fit, found.options.mass, found.options.mass_std)
    ]


def _with_per_mass(one: EngineeringValue) -> str:
    text = _quantity(one.value)
    if one.per_mass is None:
        return text
    return f"{text} (per unit {'inertia' if 'N m' in one.value.unit else 'mass'} {_quantity(one.per_mass)})"


def _quantity(value: Estimate) -> str:
    return f"{typeset_error(value.value, value.std)}{SPACE}{typeset_unit(value.unit)}".rstrip()


def _names(fit: Fit) -> str:
    return " + ".join(plain_name(name) for name in fit.model.names)


def _nothing_explains(found: Findings) -> str:
    if found.identification is None:
        return f"not identified: {found.left_out['identification']}"
    own = found.identification.adequacy
    if own is None:
        return found.identification.refusals.get("adequacy", "no model was fitted to this record")
    judged = f"{_names(own.fit)}: {judgement(own)}"
    if found.diagnosis is not None and found.diagnosis.named and found.ladder is None:
        return f"{judged}; add what the diagnosis names, then write the report again"
    return judged


def _others(found: Findings, model: Explaining | None) -> Rows:
    """Return the models beside the one that explains the record: which each is, and what it leaves."""
    rows: Rows = []
    for compared in (found.first, found.compared):
        if compared is None or (model is not None and compared.words == model.words):
            continue
        name = compared.words.removeprefix("the ").split(",")[0]
        left = residual_words(compared.error.motion_percent, compared.error.chi_square)
        rows.append((name, f"{_names(compared.judged.fit)}: leaves {left}"))
    return rows


def _floor(std: float) -> str:
    return f" (noise alone: {floor_words(std)})"
