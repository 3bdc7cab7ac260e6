"""A comparison in one screenful of 80 columns."""

import numpy as np
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from identify.comparison.discrepancy_text import DiscrepancyText
from identify.formatting import plain_name, scaled
from station.story.compared import Compared
from station.story.residual import floor_words, residual_words
from station.text.layout import labelled
from station.text.numbers import energy_scale, three_figures, with_error

ROWS, FEW_PLACES = 8, 2
LABEL_WIDTH = 12


def show_comparison(console: Console, compared: Compared, *, full: bool = False) -> None:
    """Print the residual, whether a sensor or physics is to blame, and the worst places.

    `full` adds the force error and chi-square, the noise, the errors cycle by cycle, the harmonics.
    """
    found, fit, error = compared.comparison, compared.baseline.fit, compared.error
    names = " + ".join(plain_name(name) for name in fit.model.names)
    lines = [("model", f"{compared.words}: {names}")]
    lines += [("", compared.remark)] if compared.remark else []
    lines += [("fit", fit.outcome)] if not fit.converged or fit.unidentifiable else []
    lines.append(("residual", _residual(compared)))
    if full:
        lines += [
            ("chi-square", f"{three_figures(error.chi_square)} (noise alone: 1 ± {error.floor_std:.2f})"),
            ("force error", f"{three_figures(error.force_mse_percent)} % of the mean square at the measured motion "
             f"(noise alone: {three_figures(found.force_floor)} %)"),
            ("noise", floor_text(compared)),
        ]  # fmt: skip
    lines.append(("cause", found.cause))
    if compared.one_run:
        lines.append(("one run", compared.one_run))
    places = found.places if full else found.places[:FEW_PLACES]
    lines += [(f"{place.significance:.0f} sigma", place.text) for place in places] or [("", found.summary)]
    console.print()
    console.print(Text(f" {compared.name}", style="bold"))
    for label, text in lines:
        console.print(labelled(label, text, LABEL_WIDTH))
    console.print()
    if full:
        console.print(Padding(cycles(compared), (0, 0, 0, 1)))
        console.print()
        console.print(labelled("harmonics", harmonics_text(compared), LABEL_WIDTH))
        console.print()


def _residual(compared: Compared) -> str:
    error = compared.error
    cycles = error.horizon_s * compared.baseline.fit.frequency / (2.0 * np.pi)
    return (
        f"{residual_words(error.motion_percent, error.chi_square)} (noise alone: "
        f"{three_figures(compared.motion_floor)} %, {floor_words(error.floor_std)}), in a free run of "
        f"{three_figures(error.horizon_s)} s or {cycles:.0f} cycles"
    )


def floor_text(compared: Compared) -> str:
    """Return the noise of each channel with its uncertainty and where it came from."""
    found = compared.comparison
    units_of = {
        "displacement": found.unit,
        "velocity": f"{found.unit}/s",
        "acceleration": f"{found.unit}/s^2",
    }
    parts = []
    for name, noise in found.floor.items():
        share = 100.0 * noise.uncertainty / noise.std if noise.std > 0 else float("nan")
        parts.append(f"{name} {scaled(noise.std, units_of[name])} ± {share:.0f} % ({noise.source})")
    return "; ".join(parts)


def cycles(compared: Compared) -> Table:
    """Return the errors cycle by cycle, at most eight of them, evenly taken."""
    found = compared.comparison
    units = DiscrepancyText(found.unit, found.mass)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    factor, energy = energy_scale(units)
    for name in ("time", "amplitude", "frequency error", "energy error a cycle", "free run misfit"):
        table.add_column(name, justify="right")
    table.add_row("s", units.length_unit, "%", energy, "noise rms", style="dim")
    done = found.cycles
    for i in np.unique(np.linspace(0, len(done.time) - 1, ROWS).round().astype(int)):
        table.add_row(
            f"{done.time[i]:.2f}",
            units.length(float(done.amplitude[i])),
            with_error(float(done.frequency_error[i]), float(done.frequency_error_std[i])),
            with_error(float(done.energy_error[i]) * factor, float(done.energy_error_std[i]) * factor),
            f"{found.free_run_misfit[i]:.1f}",
        )
    return table


def harmonics_text(compared: Compared) -> str:
    """Return the harmonics of the residual force that stand out of the noise."""
    found = compared.comparison
    units, orders = DiscrepancyText(found.unit, found.mass), found.harmonics
    parts = []
    for i, order in enumerate(orders.order):
        if orders.significance[i] > 4.0:
            amount = scaled(float(orders.amplitude[i]) * units.force_scale, units.force_unit)
            phase = round(float(np.degrees(orders.phase[i])))
            sure = f"({orders.significance[i]:.0f} sigma)"
            parts.append(
                f"constant: {amount} {sure}"
                if order == 0
                else f"{order:.0f} times the frequency: {amount} at {phase}° {sure}"
            )
    return "; ".join(parts) if parts else "none of the residual force stands out of the noise"
