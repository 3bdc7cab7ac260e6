"""A record and its identification in words: how it was sampled, whether its values may be quoted, both methods, and why."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from daq.plain_text import counted
from identify.estimate import Estimate
from identify.formatting import DASH, damping_name, plain_name, three_figures, with_error
from station.story.adequacy import judgement, scale_doubt, sigmas_apart
from station.story.engineering_values import Weighing
from station.story.pipeline import Identification
from station.text.content import Table, Told, Tone, facts
from station.text.layout import sentence
from station.text.numbers import amplitude_words, noise_words, typeset, typeset_unit

KINDS = {
    "displaced": "displaced, then let go",
    "impulse": "set going by an impulse",
    "in_motion": "already moving",
}
METHODS = (("wavelet", "wavelet"), ("restoring_force", "force"))
TONES: dict[bool | None, Tone] = {True: "good", False: "bad", None: "unsure"}


def told(name: str, result: Identification, *, full: bool = False) -> Told:
    """Tell one identification; `full` adds what each method leaves by its own measure."""
    found, tone = result.adequacy, TONES[None if result.adequacy is None else result.adequacy.quotable]
    reason = result.refusals.get("adequacy", "")
    words = f"{reason} Do not quote its values." if reason else "Nothing was identified."
    if found is not None:
        words = sentence(judgement(found))
    table = (methods_table(result, full=full),) if result.methods else ()
    return Told(f"{name}: {words}", tone, (*facts(_facts(result)), *table, *facts(reasons(result))))


def next_command(result: Identification) -> str:
    """Choose the command that comes next: to look where the model fails, at what was found, or at the recording alone."""
    if not result.methods:
        return "view"
    return "report" if result.adequacy is not None and result.adequacy.adequate else "compare"


def _facts(result: Identification) -> list[tuple[str, str]]:
    decay, found = result.decay, result.adequacy
    names = [*decay.channels, *(() if decay.force is None else ("force",))]
    sampled = sampling(len(decay), decay.rate, decay.rate_std)
    known = ((name, getattr(decay, f"noise_{name}")) for name in decay.channels)
    noises = [noise_words(name, noise, decay.unit) for name, noise in known if noise is not None]
    return [
        ("model", "" if found is None else " + ".join(plain_name(name) for name in found.effects)),
        ("record", f"{sampled}: {' and '.join(names)}"),
        ("mass", mass_words(result.weighing)),
        ("release", release_words(result)),
        (
            "lost",
            f"{counted(result.lost_samples, 'sample', 'samples')}, marked and left out"
            if result.lost_samples
            else "",
        ),
        ("noise", f"{', '.join(noises)} rms, before any fit" if noises else ""),
        ("lag", lag_words(result)),
        ("scale", "" if result.alignment is None else scale_doubt(result.alignment.gain)),
        ("clock", "" if result.wavelet is None else typeset(result.wavelet.clock)),
    ]


def release_words(result: Identification) -> str:
    """Say when and how the mass was released, how far from its rest, and how long it had been still."""
    decay, release, size = result.decay, result.release, result.amplitude
    if decay.driven:
        return "none: a recorded force drives the motion to the end"
    words = f"at {with_error(release.time_s, release.std_s)} s: {KINDS.get(release.kind, release.kind)}"
    if size is not None:
        words += f", {amplitude_words(size, decay.unit)} from its rest position"
    rest = (release.rest[1] - release.rest[0]) / decay.rate
    return f"{words}, after {rest:.2f} s at rest" if rest > 0.0 else words


def lag_words(result: Identification) -> str:
    """Say by how much the displacement is late or early, and how the gains differ; why not where that is not known."""
    found = result.alignment
    if found is None:
        return result.refusals.get("alignment", "not sought: it needs two channels")
    late = "late" if found.lag.value >= 0 else "early"
    lag = with_error(abs(found.lag.value) * 1e6, found.lag.std * 1e6)
    gain = with_error(found.gain.value, found.gain.std)
    caution = f". {found.caution}" if found.caution else ""
    return f"displacement {late} by {lag} µs, corrected; acceleration gain relative to it {gain}{caution}"


def methods_table(result: Identification, *, full: bool = False) -> Table:
    """Put both methods side by side: each parameter with its error, and by how many joint standard errors they differ.

    `full` adds the mean square that each leaves of what it fits, its envelope or its force, which no other residual is.
    """
    both = (result.wavelet, result.restoring_force)
    found = [{} if method is None else method.parameters for method in both]
    rows = []
    for name in dict.fromkeys(name for values in found for name in values):
        values = [one.get(name) for one in found]
        if name.startswith("stiffness of") and not any(v and abs(v.value) > 2 * v.std for v in values):
            continue
        weighed = values if "stiffness" in name else [result.weighing.strength(value) for value in values]
        rows.append(_row(typeset(name), weighed))
    force = result.restoring_force
    if force is not None and force.mass is not None:
        rows.append(_row("mass, by the force", [None, force.mass]))
    rows.append(("damping order", "", *(DASH if m is None else str(m.order) for m in both), ""))
    if full:
        left = (DASH if m is None else three_figures(m.mse_percent_by_order[m.order]) for m in both)
        rows.append(("own residual, mean square", "%", *left, ""))
    doubt = result.adequacy is None or not result.adequacy.quotable
    heads = ("wavelet", "restoring force")
    head = ("do not quote" if doubt else "", "unit", *heads, "apart, σ")
    return Table("", head, tuple(rows), texts=2, marks=("weak" if doubt else "",) * len(rows))


def _row(name: str, values: list[Estimate | None]) -> tuple[str, ...]:
    unit = next((value.unit for value in values if value is not None), "")
    first, second = values
    apart = "" if first is None or second is None else f"{sigmas_apart(first, second):.1f}"
    cells = [DASH if value is None else with_error(value.value, value.std) for value in values]
    return (name, typeset_unit(unit), *cells, apart)


def reasons(result: Identification) -> list[tuple[str, str]]:
    """Say why each method chose its order or found nothing, and which error the lag would have caused."""
    found = []
    for step, label in METHODS:
        method = getattr(result, step)
        refused = f"not identified: {result.refusals[step]}" if step in result.refusals else ""
        found.append((label, typeset(refused if method is None else method.reason)))
    warning = uncorrected(result)
    return [*found, ("the lag", f"without its correction {warning}" if warning else "")]


def uncorrected(result: Identification) -> str:
    """State the error that the lag would have caused in the restoring force's viscous damping, or "".

    A displacement that is late by tau adds w0^2 tau to mu_1.
    """
    found, aligned = result.restoring_force, result.alignment
    if found is None or aligned is None or len(found.damping) < 2 or result.decay.displacement is None:
        return ""
    right, weighing = found.damping[1], result.weighing
    wrong = replace(right, value=right.value + found.stiffness_per_mass.value * aligned.lag.value)
    values = (weighing.strength(one) for one in (wrong, right))
    said = " instead of ".join(f"{one.value:.4g} {typeset_unit(one.unit)}" for one in values)
    return f"the restoring force would have given {typeset(damping_name(1))} = {said}"


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
