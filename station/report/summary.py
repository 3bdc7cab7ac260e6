"""The result on the first page: what was found, how well it explains the measurement, what is missing."""

from station.report.equation import caution
from station.report.findings import Findings
from station.report.numbers import SPACE, rounded, symbol, three, unit
from station.text.diagnosis_text import headline


def summary(found: Findings) -> tuple[tuple[str, str], ...]:
    """Return labels and sentences, most important first."""
    rows = []
    if found.identification is not None:
        for label, method in (("wavelet", found.identification.wavelet),
                              ("restoring force", found.identification.restoring_force)):  # fmt: skip
            if method is not None:
                values = [("K", method.stiffness), *((f"mu_{i}", v) for i, v in enumerate(method.damping))]
                text = "; ".join(
                    f"{symbol(n)} = {rounded(v.value, v.std)}{SPACE}{unit(v.unit)}" for n, v in values
                )
                rows.append((f"by the {label}", text))
    else:
        rows.append(("not identified", found.left_out["identification"]))
    if found.compared is not None:
        seen = found.compared.comparison
        rows.append(
            ("usual model", f"leaves {three(seen.motion_error)} % of the motion, {three(seen.chi_square)} times what "
             "noise explains")
        )  # fmt: skip
    if found.diagnosis is not None:
        rows.append(("diagnosis", headline(found.diagnosis).replace("_", " ")))
    if found.climb is not None and found.climb.ladder.present > 0:
        compared = found.climb.compared
        seen, names = compared.comparison, " + ".join(compared.start.fit.model.names)
        left = (
            f"{three(seen.motion_error)} % of the motion, {three(seen.chi_square)} times what noise explains"
        )
        rows.append(("present model", f"{names}: leaves {left}"))
    final = found.climb.compared if found.climb is not None else found.compared
    if final is not None:
        doubt = caution(final)
        rows.append(("adequacy", doubt or "The model explains the measurement within its noise."))
    return tuple(rows)
