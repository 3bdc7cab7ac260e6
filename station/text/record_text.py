"""A record in words: how it was sampled, how heavy the mass was, and which samples are flagged."""

from collections.abc import Iterable
from typing import Any

from identify.formatting import with_error
from station.story.engineering_values import Weighing


def sampling(samples: int, rate: float, rate_std: float | None) -> str:
    """Return "2240 samples at 256.000 ± 0.003 Hz (8.75 s)"; without an error the rate is taken as exact, which is said."""
    hertz = with_error(rate, rate_std) if rate_std else f"{rate:.8g}"
    given = "" if rate_std else ", the rate taken as exact"
    return f"{samples} samples at {hertz} Hz ({samples / rate:.4g} s){given}"


def mass_words(weighing: Weighing) -> str:
    """Write the mass with its error, or that there is none."""
    if weighing.mass is None:
        return weighing.words
    mass = with_error(weighing.mass, weighing.mass_std) if weighing.mass_std else f"{weighing.mass:g}"
    return f"{mass} {'kg m²' if weighing.unit == 'rad' else 'kg'}"


def flagged_lines(flags: Iterable[dict[str, Any]], rate: float) -> list[str]:
    """Return a line for each channel and flag of runs (`channel`, `flag`, `first`, `count`) at `rate` Hz."""
    found: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for run in flags:
        found.setdefault((run["channel"], run["flag"]), []).append((run["first"], run["count"]))
    return [
        f"{channel}: {flag}, {sum(count for _, count in spans)} samples"
        f" from {spans[0][0] / rate:.3f} to {(spans[-1][0] + spans[-1][1]) / rate:.3f} s"
        for (channel, flag), spans in found.items()
    ]
