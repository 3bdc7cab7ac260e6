"""The result on the first page: values that may be quoted, of the model that explains the record, and what does not."""

from dataclasses import dataclass

from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.formatting import damping_name, plain_name
from station.report.equation import caution
from station.report.findings import Findings
from station.story.adequacy import judgement, scale_doubt
from station.story.compared import Compared
from station.story.engineering_values import EngineeringValue, engineering_values
from station.text.diagnosis_text import confirmed_by, headline
from station.text.layout import sentence
from station.text.numbers import SPACE, typeset_error, typeset_figures, typeset_symbol, typeset_unit

Rows = list[tuple[str, str]]


@dataclass(frozen=True, eq=False)
class Explaining:
    """The model that explains the record: its fit, and what it leaves, in words."""

    fit: Fit
    left: str


def summary(found: Findings) -> tuple[tuple[str, str], ...]:
    """Return labels and sentences, most important first."""
    model = explaining(found)
    rows: Rows = []
    if model is not None:
        rows.append(("model", f"{_names(model.fit)}: {model.left}"))
        rows += values(model.fit, found)
        aligned = None if found.identification is None else found.identification.alignment
        doubt = "" if aligned is None else scale_doubt(aligned.gain)
        rows += [("scale", doubt)] if doubt else []
    else:
        rows.append(("no value to quote", _nothing_explains(found)))
    rows += _usual(found, model)
    rows += _methods(found)
    if found.diagnosis is not None:
        rows.append(("diagnosis", headline(found.diagnosis)))
        confirmed = confirmed_by(found.diagnosis)
        if confirmed:
            rows.append(("prediction", sentence(confirmed)))
    refined_explains = found.refined is not None and found.refined.top.at_floor
    if found.refined is not None and found.refined.ladder.present > 0 and not refined_explains:
        compared = found.refined.compared
        rows.append(("present model", f"{_names(compared.baseline.fit)}: leaves {_left(compared)}"))
    final = found.refined.compared if found.refined is not None else found.compared
    if final is not None:
        doubt = caution(final)
        rows.append(("adequacy", doubt or "The model explains the measurement within its noise."))
    return tuple(rows)


def explaining(found: Findings) -> Explaining | None:
    """Return the model that explains the record, the refined one first, then that which was identified; None without."""
    refined, adequate = found.refined, None
    if found.identification is not None:
        adequate = found.identification.adequacy
    if adequate is not None and adequate.doubt:
        return None
    if refined is not None and refined.top.at_floor:
        top = refined.top
        return Explaining(top.stated, _over_noise(top.error.chi_square, top.error.floor_std))
    if adequate is not None and adequate.adequate:
        return Explaining(adequate.fit, _over_noise(adequate.chi_square, adequate.chi_square_std))
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


def _over_noise(chi_square: float, std: float) -> str:
    return f"leaves {typeset_figures(chi_square)} x the noise (noise floor 1 ± {std:.2f})"


def _nothing_explains(found: Findings) -> str:
    if found.identification is None:
        return f"not identified: {found.left_out['identification']}"
    own = found.identification.adequacy
    if own is None:
        return found.identification.refusals.get("adequacy", "no model was fitted to this record")
    judged = f"{_names(own.fit)}: {judgement(own)}"
    if found.diagnosis is not None and found.diagnosis.named and found.refined is None:
        return f"{judged}; add what the diagnosis names, then write the report again"
    return judged


def _usual(found: Findings, model: Explaining | None) -> Rows:
    """Return the model to begin with beside the one that explains the record, as what it is."""
    if found.compared is None:
        return []
    fit, name = found.compared.judged.fit, found.compared.words.removeprefix("the ").split(",")[0]
    left = f"leaves {_left(found.compared)}"
    if model is not None and set(model.fit.model.names) == set(fit.model.names):
        return [(name, left)]
    quoted = "; ".join(
        f"{one.name} {_quantity(one.value)}"
        for one in engineering_values(
            found.compared.judged.stated(fit), found.options.mass, found.options.mass_std
        )
    )
    return [(name, f"{left}; not to be quoted, for comparison only: {quoted}")]


def _methods(found: Findings) -> Rows:
    """Return what the paper's two methods found, and whether that may be quoted."""
    if found.identification is None:
        return []
    own = found.identification.adequacy
    doubt = "" if own is not None and own.quotable else "do not quote: "
    rows = []
    for label, method in (("wavelet", found.identification.wavelet),
                          ("restoring force", found.identification.restoring_force)):  # fmt: skip
        if method is None:
            continue
        given = [
            ("K", method.stiffness),
            *((damping_name(i).split()[-1], v) for i, v in enumerate(method.damping)),
        ]
        text = "; ".join(f"{typeset_symbol(name)} = {_quantity(value)}" for name, value in given)
        rows.append((f"by the {label}", doubt + text))
    return rows


def _left(compared: Compared) -> str:
    error = compared.error
    motion, chi_square = typeset_figures(error.motion_percent), typeset_figures(error.chi_square)
    return f"{motion} % of the motion, {chi_square} x the noise"
