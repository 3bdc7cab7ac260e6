"""A comparison in one screenful of 80 columns."""

import numpy as np
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from identify.comparison.discrepancy_text import DiscrepancyText, scaled
from station.quantities import written
from station.story.compared import Compared

ROWS = 8


def show_comparison(console: Console, compared: Compared) -> None:
    """Print the errors, whether a sensor or physics is to blame, the worst places, the cycles, the harmonics."""
    found, fit = compared.comparison, compared.start.fit
    console.print()
    console.print(Text(f" {compared.name}: compared with {' + '.join(fit.model.names)}", style="bold"))
    if not fit.converged or fit.unidentifiable:
        console.print(_line("fit", fit.outcome))
    console.print()
    console.print(Padding(errors(compared), (0, 0, 0, 1)))
    console.print()
    console.print(_line("floor", floor_text(compared)))
    console.print(_line("cause", found.cause))
    console.print()
    console.print(Text(" Worst places", style="bold"))
    if not found.places:
        console.print(f" {found.summary}", markup=False)
    for number, place in enumerate(found.places, start=1):
        console.print(_line(f"{number}. {place.significance:.0f} sigma", place.text))
    console.print()
    console.print(Padding(cycles(compared), (0, 0, 0, 1)))
    console.print()
    console.print(_line("harmonics", harmonics_text(compared)))
    console.print()


def _line(label: str, text: str) -> Table:
    line = Table.grid(padding=(0, 1))
    line.add_column(width=13)
    line.add_column(overflow="fold")
    line.add_row(Text(f" {label}", style="cyan"), Text(text))
    return line


def errors(compared: Compared) -> Table:
    """Return the three errors side by side with what each means and what noise alone would leave."""
    found = compared.comparison
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("error")
    table.add_column("value", justify="right")
    table.add_column("at the floor", justify="right")
    table.add_column("meaning")
    table.add_row(
        "force",
        f"{found.force_error:.3g} %",
        f"{found.force_floor:.2g} %",
        "eq. (18), at the measured motion",
    )
    horizon = f"free run, rms, {found.horizon:.2g} s ({found.horizon_cycles:.0f} cycles)"
    lowest = 100.0 * found.floor[found.motion_channel].std / _rms(compared)
    table.add_row("motion", f"{found.motion_error:.3g} %", f"{lowest:.2g} %", horizon)
    table.add_row(
        "chi-square",
        f"{found.chi_square:.4g}",
        f"1 ± {found.chi_square_std:.2f}",
        "over the noise; 1: nothing left",
    )
    return table


def _rms(compared: Compared) -> float:
    span, channel = compared.start.fit.windows[0], compared.comparison.motion_channel
    return float(np.std(span.readings[channel][span.used[channel]]))


def floor_text(compared: Compared) -> str:
    """Return the noise of each channel with its uncertainty and where it came from."""
    found = compared.comparison
    units = {"displacement": found.unit, "velocity": f"{found.unit}/s", "acceleration": f"{found.unit}/s^2"}
    parts = []
    for name, noise in found.floor.items():
        share = 100.0 * noise.uncertainty / noise.std if noise.std > 0 else float("nan")
        parts.append(f"{name} {scaled(noise.std, units[name])} ± {share:.0f} % ({noise.source})")
    return "; ".join(parts)


def cycles(compared: Compared) -> Table:
    """Return the errors cycle by cycle, at most eight of them, evenly taken."""
    found = compared.comparison
    words = DiscrepancyText(found.unit, found.mass)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    energy, factor = _energy_unit(compared)
    for name in ("time", "amplitude", "frequency error", "energy error a cycle", "free run off"):
        table.add_column(name, justify="right")
    table.add_row("s", words.length_unit, "%", energy, "noise rms", style="dim")
    done = found.cycles
    for i in np.unique(np.linspace(0, len(done.time) - 1, ROWS).round().astype(int)):
        table.add_row(
            f"{done.time[i]:.2f}",
            words.length(float(done.amplitude[i])),
            _with_error(float(done.frequency_error[i]), float(done.frequency_error_std[i])),
            _with_error(float(done.energy_error[i]) * factor, float(done.energy_error_std[i]) * factor),
            f"{found.free_run_misfit[i]:.1f}",
        )
    return table


def _with_error(value: float, std: float) -> str:
    from station.quantities import with_error

    return with_error(value, std)


def _energy_unit(compared: Compared) -> tuple[str, float]:
    """Return the unit in which energies are shown and the factor on J/kg that leads to it."""
    found = compared.comparison
    words = DiscrepancyText(found.unit, found.mass)
    if found.unit not in ("m", "rad") or (found.mass is None and found.unit == "rad"):
        return words.energy_unit, 1.0
    return f"m{words.energy_unit}", 1e3 * words.force_scale


def harmonics_text(compared: Compared) -> str:
    """Return the harmonics of the residual force that stand out of the noise."""
    found = compared.comparison
    words, orders = DiscrepancyText(found.unit, found.mass), found.harmonics
    parts = []
    for i, order in enumerate(orders.order):
        if orders.significance[i] > 4.0:
            amount = scaled(float(orders.amplitude[i]) * words.force_scale, words.force_unit)
            phase = np.degrees(orders.phase[i])
            parts.append(
                f"{order:.0f} times the frequency: {amount} at {phase:.0f}° ({orders.significance[i]:.0f} sigma)"
            )
    return "; ".join(parts) if parts else "none of the residual force stands out of the noise"


def parameters_text(compared: Compared) -> str:
    """Return the fitted parameters with their errors."""
    values = compared.start.fit.parameters
    return ", ".join(f"{name} {written(value)} {value.unit}" for name, value in values.items())
