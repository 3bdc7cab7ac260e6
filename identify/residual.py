"""The residual of a record in one measure for people, and the share of it that a suspect would explain.

The measure is the residual in % of the motion, and its rms as a multiple of the noise: amplitudes, not powers.
"""

from math import isfinite, nan, sqrt

from identify.formatting import share_words, three_figures


def noise_multiple(chi2: float | None) -> float:
    """Return the rms of a residual over that of the noise, from its reduced chi-square; nan where that is not known."""
    return sqrt(chi2) if chi2 is not None and chi2 >= 0.0 else nan


def times(chi2: float | None) -> str:
    """Write the same with three figures, as "15.1"; "-" where it is not known."""
    return three_figures(noise_multiple(chi2))


def residual_words(motion_percent: float | None, chi2: float | None, above: float | None = None) -> str:
    """Return "0.916 % of the motion, 15.1 times the noise"; of a run that diverged, that it does not follow the motion.

    `above` is the standard error of a floor that is not reached: a residual as small as noise then repeats with the motion.
    """
    percent = nan if motion_percent is None else motion_percent
    if not isfinite(percent) and not isfinite(noise_multiple(chi2)):
        return "the whole motion, which it does not follow at all"
    small = above is not None and reaches_floor(chi2, above)
    more = ", but it repeats with the motion, as noise does not" if small else ""
    return f"{three_figures(percent)} % of the motion, {times(chi2)} times the noise{more}"


def floor_words(chi2_std: float | None) -> str:
    """Return "1 ± 0.035", which is the rms of a residual over that of the noise where noise alone is left."""
    if chi2_std is None or not isfinite(chi2_std):
        return "1 (error not known)"
    return f"1 ± {chi2_std / 2.0:.2g}"


def would_explain(before: float | None, after: float | None) -> str:
    """Return the share of a residual's mean square above the noise that a suspect takes away: "61 %", "nothing".

    "-" where it is not known.
    """
    if before is None or after is None or not isfinite(before) or not isfinite(after):
        return "-"
    return share_words(share_explained(before, after))


def share_explained(before: float, after: float) -> float:
    """Return the share, 0 to 1, of a residual's mean square above the noise that an effect takes away."""
    return min(max((before - after) / (before - 1.0), 0.0), 1.0) if before > 1.0 else 0.0


def explained_words(before: float | None, after: float | None, spread: float | None) -> str:
    """Return "would explain 61 %", or "all of it" at the floor, whose standard error is `spread`; "" if not known."""
    words = would_explain(before, after)
    if words == "-" or before is None or before <= 1.0:
        return ""
    return f"would explain {'all of it' if reaches_floor(after, spread) else words}"


def reaches_floor(after: float | None, std: float | None) -> bool:
    """Check whether a reduced chi-square is the noise floor, `std` being its standard error."""
    return after is not None and isfinite(after) and after <= 1.0 + 3.0 * (std or 0.0)
