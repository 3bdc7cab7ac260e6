"""A comparison in one screenful of 80 columns."""

import numpy as np
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from identify.comparison.discrepancy_text import DiscrepancyText
from identify.formatting import plain_name, scaled
from station.story.compared import Compared
from station.text.layout import labelled
from station.text.numbers import energy_scale, three_figures, with_error

ROWS = 8
LABEL_WIDTH = 15


def show_comparison(console: Console, compared: Compared) -> None:
    """Print the errors, whether a sensor or physics is to blame, the worst places, the cycles, the harmonics."""
    found, fit = compared.comparison, compared.baseline.fit
    console.print()
    console.print(Text(f" {compared.name}: compared with {compared.words}", style="bold"))
    console.print(labelled("model", " + ".join(plain_name(name) for name in fit.model.names), LABEL_WIDTH))
    if compared.remark:
        console.print(labelled("", compared.remark, LABEL_WIDTH))
    if not fit.converged or fit.unidentifiable:
        console.print(labelled("fit", fit.outcome, LABEL_WIDTH))
    console.print()
    console.print(Padding(errors(compared), (0, 0, 0, 1)))
    console.print()
    console.print(labelled("floor", floor_text(compared), LABEL_WIDTH))
    console.print(labelled("cause", found.cause, LABEL_WIDTH))
    if compared.one_run:
        console.print(labelled("one run", compared.one_run, LABEL_WIDTH))
    console.print()
    console.print(Text(" Worst places", style="bold"))
    if not found.places:
        console.print(f" {found.summary}", markup=False)
    for number, place in enumerate(found.places, start=1):
        console.print(labelled(f"{number}. {place.significance:.0f} sigma", place.text, LABEL_WIDTH))
    console.print()
    console.print(Padding(cycles(compared), (0, 0, 0, 1)))
    console.print()
    console.print(labelled("harmonics", harmonics_text(compared), LABEL_WIDTH))
    console.print()


def errors(compared: Compared) -> Table:
    """Return the three errors side by side with what each means and what noise alone would leave."""
    found, error = compared.comparison, compared.error
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("error")
    table.add_column("value", justify="right")
    table.add_column("at the floor", justify="right")
    table.add_column("meaning")
    table.add_row(
        "force",
        f"{three_figures(error.force_mse_percent)} %",
        f"{three_figures(found.force_floor)} %",
        "eq. (18), at the measured motion",
    )
    cycles = error.horizon_s * compared.baseline.fit.frequency / (2.0 * np.pi)
    horizon = f"free run, rms, {three_figures(error.horizon_s)} s ({cycles:.0f} cycles)"
    table.add_row(
        "motion",
        f"{three_figures(error.motion_percent)} %",
        f"{three_figures(compared.motion_floor)} %",
        horizon,
    )
    table.add_row(
        "chi-square",
        three_figures(error.chi_square),
        f"1 ± {error.floor_std:.2f}",
        "over the noise; 1: nothing left",
    )
    return table


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
