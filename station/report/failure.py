"""The section of the comparison: how large the errors of the current model are, what they mean, and where it fails."""

from station.report.findings import Findings
from station.report.section import Section
from station.text.comparison_text import told
from station.text.content import Figure, Part, left_out
from station.views import comparison_figures as draw

TITLE = "The current model, compared with the measurement"


def comparison(found: Findings) -> Section:
    """Say and draw where the current model fails."""
    compared = found.compared
    if compared is None:
        return Section("comparison", TITLE, (left_out(found.left_out["comparison"]),))
    words = told(compared)
    figures: tuple[Part, ...] = (
        Figure(
            "The force that the model lacks over the phase plane (+ and −: beyond 3 standard errors), and its "
            "sections with 2 standard errors.",
            draw.phase_plane(compared.comparison),
        ),
        Figure(
            "Measured less model, cycle by cycle, with 2 standard errors.", draw.cycles(compared.comparison)
        ),
    )
    return Section("comparison", TITLE, (*words.brief, *words.more[:-1], *figures, *words.more[-1:]))
