"""The result on the first page: what was found, how well it explains the measurement, what is missing."""

from station.report.equation import caution
from station.report.findings import Findings
from station.story.compared import Compared
from station.text.diagnosis_text import confirmed_by, headline
from station.text.layout import sentence
from station.text.numbers import SPACE, typeset_error, typeset_figures, typeset_symbol, typeset_unit


def summary(found: Findings) -> tuple[tuple[str, str], ...]:
    """Return labels and sentences, most important first."""
    rows = []
    if found.identification is not None:
        for label, method in (("wavelet", found.identification.wavelet),
                              ("restoring force", found.identification.restoring_force)):  # fmt: skip
            if method is not None:
                values = [("K", method.stiffness), *((f"mu_{i}", v) for i, v in enumerate(method.damping))]
                text = "; ".join(
                    f"{typeset_symbol(n)} = {typeset_error(v.value, v.std)}{SPACE}{typeset_unit(v.unit)}"
                    for n, v in values
                )
                rows.append((f"by the {label}", text))
    else:
        rows.append(("not identified", found.left_out["identification"]))
    if found.compared is not None:
        rows.append(("usual model", f"leaves {_left(found.compared)}"))
    if found.diagnosis is not None:
        rows.append(("diagnosis", headline(found.diagnosis).replace("_", " ")))
        confirmed = confirmed_by(found.diagnosis)
        if confirmed:
            rows.append(("prediction", sentence(confirmed)))
    if found.refined is not None and found.refined.ladder.present > 0:
        compared = found.refined.compared
        names = " + ".join(compared.baseline.fit.model.names)
        rows.append(("present model", f"{names}: leaves {_left(compared)}"))
    final = found.refined.compared if found.refined is not None else found.compared
    if final is not None:
        doubt = caution(final)
        rows.append(("adequacy", doubt or "The model explains the measurement within its noise."))
    return tuple(rows)


def _left(compared: Compared) -> str:
    seen = compared.comparison
    motion, chi_square = typeset_figures(seen.motion_error), typeset_figures(seen.chi_square)
    return f"{motion} % of the motion, {chi_square} times what noise explains"
