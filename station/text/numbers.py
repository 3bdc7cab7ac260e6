"""Numbers and units for people, in a terminal and, typeset, on a page."""

import re
from collections.abc import Mapping

from identify.comparison.discrepancy_text import DiscrepancyText
from identify.formatting import DASH, SPACE, Estimated, quantities, quantity, scaled, three_figures

_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def with_unit(found: Estimated) -> str:
    """Write "13115.0 ± 2.1 N/m²", or "0 N (error unknown)"; the value alone where it is exact."""
    return typeset(quantity(found))


def with_names(found: Mapping[str, Estimated]) -> list[str]:
    """Write "fc = 80.0 ± 1.2 Hz" for each parameter; the range where every release has its own ("fc[0]", "fc[1]")."""
    return [typeset(text) for text in quantities(found)]


def probability(p: float) -> str:
    """Return a probability as people read it."""
    return "<1e-6" if p < 1e-6 else f"{p:.0e}".replace("e-0", "e-") if p < 0.01 else f"{p:.2f}"


def change(before: float | None, after: float | None) -> str:
    """Say by how much something fell or rose, as a factor or in %."""
    if not before or not after:
        return ""
    if before >= 2 * after > 0:
        return f"÷ {before / after:.3g}"
    if after >= 2 * before > 0:
        return f"x {after / before:.3g}"
    percent = 100 * (after - before) / abs(before)
    return f"{percent:+.1f} %" if abs(percent) >= 0.1 else f"{percent:+.2g} %"


# Units.


def scale(channel: str, unit: str, fine: bool = False) -> tuple[float, str]:
    """Return the factor to the unit in which a channel is shown, and that unit.

    `unit` is that of the displacement (m, rad, or what a sensor gave, as V). `fine` chooses a thousand
    times smaller unit, for noise and for what a model leaves.
    """
    if channel == "displacement":
        whole = unit in ("count", "px")  # nobody speaks of a thousandth of a count
        plain, small = {"m": ((1e3, "mm"), (1e6, "um")), "rad": ((1.0, "rad"), (1e3, "mrad"))}.get(
            unit, ((1.0, unit), (1.0, unit) if whole else (1e3, f"m{unit}"))
        )
        return small if fine else plain
    return 1.0, f"{unit}/s" if channel == "velocity" else f"{unit}/s^2"


def amplitude_words(size: float | None, unit: str) -> str:
    """Write a displacement without its sign: "25.0 mm"."""
    factor, shown = scale("displacement", unit)
    return DASH if size is None else f"{three_figures(abs(size) * factor)} {typeset_unit(shown)}"


def noise_words(channel: str, noise: float, unit: str) -> str:
    """Write the rms of a channel's noise, `unit` being that of the displacement: "displacement 5 µm"."""
    return typeset(
        f"{channel} {scaled(noise, unit if channel == 'displacement' else scale(channel, unit)[1])}"
    )


def scale_as_recorded(quantity: str, unit: str) -> tuple[float, str]:
    """Return the same for a channel in its own `unit`: lengths in mm, everything else as it was recorded."""
    return scale("displacement", unit) if quantity == "displacement" else (1.0, unit)


def energy_scale(units: DiscrepancyText) -> tuple[float, str]:
    """Return the factor on an energy per unit mass to the unit in which it is shown, and that unit: mJ, mJ/kg ..."""
    fine, prefix = (1e3, "m") if units.energy_unit.startswith("J") else (1.0, "")
    return fine * units.force_scale, f"{prefix}{units.energy_unit}"


# Typeset: raised powers, Greek letters, powers of ten.


def typeset(text: str) -> str:
    """Return a sentence with raised powers, Greek letters and the signs that a terminal has no letters for."""
    raised = re.sub(r"\^(-?\d+)", lambda found: found.group(1).translate(_RAISED), text)
    greek = re.sub(r"\bmu_(\d)\b", lambda found: f"μ{found.group(1).translate(_LOWERED)}", raised)
    return re.sub(r"\bu(m|s|J|N|V|rad)\b", r"µ\1", greek).replace("+-", "±")


def typeset_unit(text: str) -> str:
    """Return a unit with raised powers: m/s^2 becomes m/s²; "1" (a pure number) becomes nothing."""
    return "" if text == "1" else typeset(text).replace(" ", SPACE)
