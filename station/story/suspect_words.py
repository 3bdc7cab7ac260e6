"""What a suspect would explain, in words that hold: a share of what the model leaves above the noise, and the floor."""

from math import isfinite

from identify.formatting import share_words


def explained_share(before: float | None, after: float | None) -> float | None:
    """Return the share, 0 to 1, of the reduced chi-square above 1 that a suspect takes away; None where it is not known."""
    if before is None or after is None or not isfinite(before) or not isfinite(after):
        return None
    return min(max((before - after) / (before - 1.0), 0.0), 1.0) if before > 1.0 else 0.0


def would_explain(before: float | None, after: float | None) -> str:
    """Return what a suspect would explain of what the model leaves: "99.9 %", "61 %", "nothing"; "-" if not known."""
    share = explained_share(before, after)
    return "-" if share is None else share_words(share)


def reaches_floor(after: float | None, std: float | None, sure: bool) -> bool:
    """Whether a reduced chi-square is the noise floor, `std` being its standard error; a guessed floor is doubted."""
    if after is None or not isfinite(after):
        return False
    return after <= 1.0 + max(3.0 * (std or 0.0), 0.0 if sure else 0.5)
