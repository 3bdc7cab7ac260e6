"""What a suspect would explain: the share of what the model leaves above the noise, in words."""


def explained(before: float | None, after: float | None) -> float | None:
    """Return the share, in %, of the misfit above the noise that goes; `before` and `after` are reduced chi-squares."""
    if before is None or after is None or before <= 1.0:
        return None
    return 100.0 * min(1.0, max(0.0, (before - after) / (before - 1.0)))


def explained_words(before: float | None, after: float | None, spread: float | None) -> str:
    """Return "explains 61 %", "explains nothing", or that nothing but noise is left; "" where it is not known.

    `spread` is the standard error of the reduced chi-square of an adequate model.
    """
    share = explained(before, after)
    if share is None or after is None:
        return ""
    if after <= 1.0 + 3.0 * (spread or 0.0):
        return "would explain all of it"
    if share < 0.1:
        return "would explain nothing"
    return f"would explain {percent(share)} %"


def percent(share: float) -> str:
    """Return a share with the digits that tell it from all and from nothing."""
    if share >= 99.0:
        return f"{min(share, 99.99):.2f}"
    return f"{share:.0f}" if share >= 10.0 else f"{share:.1f}"
