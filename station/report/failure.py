"""The section of the comparison: how large the errors of the current model are, what they mean, and where it fails."""

import numpy as np

from identify.comparison.discrepancy_text import DiscrepancyText
from identify.formatting import plain_name
from station.report import comparison_figures as draw
from station.report.content import Facts, Figure, Paragraph, Part, Section, Table, left_out
from station.report.findings import Findings
from station.story.compared import Compared
from station.story.residual import floor_words, times
from station.text.comparison_text import floor_text, harmonics_text
from station.text.layout import sentence
from station.text.numbers import energy_scale, typeset, typeset_error, typeset_figures, typeset_unit

TITLE = "The current model, compared with the measurement"
MOST_CYCLES = 12


def comparison(found: Findings) -> Section:
    """Say and draw where the current model fails, and how much less than the one that the ladder began with."""
    compared = found.compared
    if compared is None:
        return Section("comparison", TITLE, (left_out(found.left_out["comparison"]),))
    seen, fit = compared.comparison, compared.baseline.fit
    parts: list[Part] = [
        Paragraph(
            f"{sentence(compared.words).rstrip('.')}: {' + '.join(plain_name(name) for name in fit.model.names)}, fitted to "
            "the record and run freely.",
            label="Model",
        ),
        errors(compared),
        Paragraph(seen.cause, label="Sensor or physics", strong=True),
    ]
    if compared.one_run:
        parts.append(Paragraph(compared.one_run, label="Long record"))
    if not fit.converged or fit.unidentifiable:
        parts.append(Paragraph(fit.outcome, label="Fit"))
    if found.first is not None:
        caption = f"Residuals of {found.first.words} and of {compared.words} (band: noise, 2 std.); mind the scales."
        parts.append(Figure(caption, draw.closing_in(found.first, compared)))
    parts.append(places(compared))
    facts = (
        ("noise floor", floor_text(compared)),
        ("harmonics of the missing force", harmonics_text(compared)),
    )
    parts.append(Facts(tuple((label, typeset(text)) for label, text in facts)))
    parts += [
        Figure(
            "Measured (grey) and modelled motion, and what is left (band: noise, 2 std.).",
            draw.overlay(compared),
        ),
        Figure(
            "The force that the model lacks over the phase plane (+ and −: beyond 3 standard errors), and its "
            "sections with 2 standard errors.",
            draw.phase_plane(compared),
        ),
        Figure("Measured less model, cycle by cycle, with 2 standard errors.", draw.cycles(compared)),
        cycle_table(compared),
    ]
    return Section("comparison", TITLE, tuple(parts))


def errors(compared: Compared) -> Table:
    """Return the three errors with what noise alone would leave and what each means."""
    seen, error = compared.comparison, compared.error
    count = error.horizon_s * compared.baseline.fit.frequency / (2.0 * np.pi)
    cycles = f"{typeset_figures(error.horizon_s)} s ({count:.0f} cycles)"
    rows = (
        ("force", f"{typeset_figures(error.force_mse_percent)} %", f"{typeset_figures(seen.force_floor)} %",
         "mean square, eq. (18), with the force taken at the measured motion"),
        ("motion", f"{typeset_figures(error.motion_percent)} %", f"{typeset_figures(compared.motion_floor)} %",
         f"rms of the free run over {cycles}, of the {seen.motion_channel}'s rms"),
        ("residual", f"{times(error.chi_square)} times the noise", floor_words(error.floor_std),
         f"rms, of all channels; its square is the reduced chi², {typeset_figures(error.chi_square)}"),
    )  # fmt: skip
    return Table("Errors of the model", ("error", "value", "noise alone", "meaning"), rows, wordy=True)


def places(compared: Compared) -> Part:
    """Return the worst places in units, worst first, or the sentence that there are none."""
    found = compared.comparison.places
    if not found:
        return Paragraph(compared.comparison.summary, label="Where it fails")
    rows = tuple((str(n), typeset(p.text), f"{p.significance:.0f}") for n, p in enumerate(found, start=1))
    return Table("Where it fails, worst first", ("", "place", "std. errors"), rows, texts=2)


def cycle_table(compared: Compared) -> Table:
    """Return the errors cycle by cycle, evenly taken where there are many."""
    seen = compared.comparison
    done, units = seen.cycles, DiscrepancyText(seen.unit, seen.mass)
    factor, energy = energy_scale(units)
    head = (
        "time [s]", f"amplitude [{units.length_unit}]", "frequency error [%]",
        f"energy error a cycle [{typeset_unit(energy)}]", "free run: misfit / noise",
    )  # fmt: skip
    count = len(done.time)
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_CYCLES)).round().astype(int))
    rows = tuple(
        (
            f"{done.time[i]:.2f}",
            units.length(float(done.amplitude[i])),
            typeset_error(float(done.frequency_error[i]), float(done.frequency_error_std[i])),
            typeset_error(float(done.energy_error[i]) * factor, float(done.energy_error_std[i]) * factor),
            f"{seen.free_run_misfit[i]:.1f}",
        )
        for i in chosen
    )
    caption = "Cycle by cycle: measured less model (± one standard error)"
    return Table(caption, head, rows, texts=0)
