"""The section of the comparison: the errors of the current model, their meaning, and where it fails."""

from station.report.findings import Findings
from station.story.compared import Compared
from station.text.comparison_text import told
from station.text.content import Figure, Part, Section, left_out
from station.views import comparison_figures as draw
from station.views.palette import PAPER, Look

TITLE = "The current model, compared with the measurement"


def comparison(found: Findings) -> Section:
    """Say and draw where the current model fails."""
    if found.compared is None:
        return Section("comparison", TITLE, (left_out(found.left_out["comparison"]),))
    return Section("comparison", TITLE, where_it_fails(found.compared))


def where_it_fails(compared: Compared, look: Look = PAPER) -> tuple[Part, ...]:
    """Say and draw where a model fails, in the colours of a look."""
    words = told(compared)
    figures = (
        Figure(
            "The force that the model lacks over the phase plane (+ and −: beyond 3 standard errors), and its "
            "sections with 2 standard errors.",
            draw.phase_plane(compared.comparison, look),
        ),
        Figure(
            "Measured less model, cycle by cycle, with 2 standard errors.",
            draw.cycles(compared.comparison, look),
        ),
    )
    return (*words.brief, *words.more, *figures)
