"""The appendix of both identifications, side by side: the paper's tables and figures, quotable or not."""

from station.report.findings import Findings
from station.text.content import Figure, Paragraph, Part, facts
from station.text.identification_text import methods_table, reasons, told
from station.text.numbers import with_unit
from station.views import identification_figures as draw


def methods(found: Findings) -> list[Part]:
    """Put both methods side by side; what was refused says why. Nothing where nothing was identified."""
    result = found.identification
    if result is None:
        return []
    why = facts(reasons(result))
    if result.wavelet is None and result.restoring_force is None:
        return [*why]
    words = Paragraph(told("This release", result).headline, strong=True)
    force, length = result.restoring_force, result.decay.unit
    offset = (
        "" if force is None else f"{force.source}; constant force per unit mass {with_unit(force.offset)}"
    )
    parts: list[Part] = [words, methods_table(result), *why, *facts([("force from", offset)])]
    if result.wavelet is not None:
        caption = (
            "Envelope on the ridge with its fit, instantaneous frequency (where it can be trusted), and backbone. "
            "A frequency that stays level means a linear stiffness."
        )
        parts.append(Figure(caption, draw.envelope(result.wavelet, length, result.release.time_s)))
    caption = (
        "Residual against the order of damping (circle: the order chosen), and significance of the terms."
    )
    parts.append(Figure(caption, draw.orders(result)))
    if force is not None:
        parts.append(Figure("Sections of the restoring force surface.", draw.sections(force, length)))
    return parts
