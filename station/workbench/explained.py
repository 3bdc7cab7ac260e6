"""What a suspect would explain, as its card says it."""

from station.story.residual import reaches_floor, would_explain


def explained_words(before: float | None, after: float | None, spread: float | None) -> str:
    """Return "would explain 61 %", "would explain nothing", "would explain all of it" at the floor; "" if not known.

    `before` and `after` are reduced chi-squares, `spread` the standard error of an adequate model's.
    """
    words = would_explain(before, after)
    if words == "-" or before is None or before <= 1.0:
        return ""
    return f"would explain {'all of it' if reaches_floor(after, spread) else words}"
