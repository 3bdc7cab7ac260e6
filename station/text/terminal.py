"""A result in one screenful of 80 columns, in words and units that a person understands."""

from pathlib import Path

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from identify.estimate import Estimate
from identify.formatting import damping_name, plain_name
from station.story.adequacy import judgement, scale_doubt
from station.story.engineering_values import times_mass
from station.story.identification import Identification
from station.text.layout import labelled, sentence
from station.text.next_step import next_line
from station.text.numbers import noise_scale, typeset, with_error

LABEL_WIDTH = 11
KINDS = {
    "displaced": "held away, then let go",
    "impulse": "set going by an impulse",
    "in_motion": "already moving at the start",
}


def show_identification(console: Console, name: str, result: Identification) -> None:
    """Print one identification: the release, the lag, both methods side by side, why, and what next."""
    console.print()
    console.print(Text(f" {name}", style="bold"))
    for label, text in _facts(result):
        console.print(labelled(label, text, LABEL_WIDTH))
    console.print()
    for label, text, style in adequacy_lines(result):
        console.print(labelled(label, text, LABEL_WIDTH, style))
    console.print()
    console.print(Padding(parameters(result), (0, 0, 0, 1)))
    console.print()
    for label, text in _reasons(result):
        console.print(labelled(label, text, LABEL_WIDTH))
    console.print()


def adequacy_lines(result: Identification) -> list[tuple[str, str, str]]:
    """Return label, text and style of what comes before any value: the model, and whether its values may be quoted."""
    found = result.adequacy
    if found is None:
        reason = result.refusals.get("adequacy")
        return [("not judged", f"{reason} Do not quote its values.", "bold yellow")] if reason else []
    lines = [
        ("model", " + ".join(plain_name(name) for name in found.effects), ""),
        ("judged", sentence(judgement(found)), "bold green" if found.quotable else "bold red"),
    ]
    doubt = "" if result.alignment is None else scale_doubt(result.alignment.gain)
    return [*lines, ("scale", doubt, "bold yellow")] if doubt else lines


def _facts(result: Identification) -> list[tuple[str, str]]:
    decay, release = result.decay, result.release
    names = [
        n for n in ("displacement", "velocity", "acceleration", "force") if getattr(decay, n) is not None
    ]
    lost = result.lost_samples
    unit = "kg m^2" if decay.unit == "rad" else "kg"
    mass = (
        f"mass not given: per unit {'inertia' if decay.unit == 'rad' else 'mass'}"
        if decay.mass is None
        else f"{decay.mass:g} {unit}"
    )
    given = " as given, the error of a clock is in no value" if decay.rate_std is None else ""
    facts = [
        ("record", f"{len(decay)} samples at {decay.rate:g} Hz{given} ({' and '.join(names)}), {mass}"),
        ("release", f"at {release.time_s:.4f} s: {KINDS.get(release.kind, release.kind)}"),
    ]
    if lost:
        facts.append(("lost", f"{lost} samples, marked and left out"))
    noise = _noise(result)
    if noise:
        facts.append(("noise", noise))
    facts.append(("lag", _lag(result)))
    if result.wavelet is not None and result.wavelet.clock:
        facts.append(("clock", result.wavelet.clock))
    return facts


def _noise(result: Identification) -> str:
    decay = result.decay
    parts = []
    for name in ("displacement", "velocity", "acceleration"):
        noise = getattr(decay, f"noise_{name}")
        if noise is not None:
            factor, unit = noise_scale(name, decay.unit, noise)
            parts.append(f"{name} {noise * factor:.3g} {unit}")
    return f"{', '.join(parts)} rms" if parts else ""


def _lag(result: Identification) -> str:
    found = result.alignment
    if found is None:
        return result.refusals.get("alignment", "not sought")
    late = "late" if found.lag.value >= 0 else "early"
    lag = with_error(abs(found.lag.value) * 1e6, found.lag.std * 1e6)
    text = f"displacement {late} by {lag} us, corrected; gain {with_error(found.gain.value, found.gain.std)}"
    return f"{text}. {found.caution}" if found.caution else text


def parameters(result: Identification) -> Table:
    """Return the table of both methods side by side."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("")
    table.add_column("unit")
    doubt = result.adequacy is None or not result.adequacy.quotable
    for name in ("wavelet", "restoring force"):
        table.add_column(f"{name}\n(do not quote)" if doubt else name, justify="right")
    for row in rows(result):
        table.add_row(*map(typeset, row), style="dim" if doubt else "")
    return table


def rows(result: Identification) -> list[tuple[str, str, str, str]]:
    """Return (name, unit, by the wavelet, by the restoring force) for each parameter, written out."""
    both = (result.wavelet, result.restoring_force)
    lines = [_row("stiffness K", [None if method is None else method.stiffness for method in both])]
    most = max((len(method.damping) for method in both if method is not None), default=0)
    for order in range(most):
        values = [
            method.damping[order] if method is not None and order < len(method.damping) else None
            for method in both
        ]
        lines += _damping_rows(damping_name(order), values, result)
    highest = {order for method in both if method is not None for order in method.stiffness_by_order}
    for order in sorted(highest - {1}):
        values = [None if method is None else method.stiffness_by_order.get(order) for method in both]
        if any(value is not None and abs(value.value) > 2 * value.std for value in values):
            lines.append(_row(f"stiffness of order {order}", values))
    weighed = None if result.restoring_force is None else result.restoring_force.mass
    if weighed is not None:
        lines.append(_row("mass, by the force", [None, weighed]))
    chosen = ["none" if method is None else str(method.order) for method in both]
    lines.append(("damping order", "", chosen[0], chosen[1]))
    errors = ["" if m is None else f"{m.mse_percent_by_order[m.order]:.3g}" for m in both]
    lines.append(("error left (MSE)", "%", errors[0], errors[1]))
    return lines


def _damping_rows(
    name: str, values: list[Estimate | None], result: Identification
) -> list[tuple[str, str, str, str]]:
    """Return a damping in N, kg and s with the same per unit mass under it; only the latter where no mass is known."""
    decay = result.decay
    if decay.mass is None:
        return [_row(name, values)]
    mass, std = decay.mass, decay.mass_std
    whole = [None if value is None else times_mass(value, mass, std, decay.unit) for value in values]
    per = "per unit inertia" if decay.unit == "rad" else "per unit mass"
    if not any(whole):
        return [_row(f"{name}, {per}", values)]
    plain, _, symbol = name.rpartition(" ")
    return [_row(plain, whole), _row(f"  {symbol}, {per}", values)]


def _row(name: str, values: list[Estimate | None]) -> tuple[str, str, str, str]:
    unit = next((value.unit for value in values if value is not None), "")
    cells = ["-" if value is None else with_error(value.value, value.std) for value in values]
    return (name, unit, cells[0], cells[1])


def _reasons(result: Identification) -> list[tuple[str, str]]:
    reasons = []
    if result.wavelet is not None:
        reasons.append(("wavelet", result.wavelet.reason))
    if result.restoring_force is not None:
        reasons.append(("force", result.restoring_force.reason))
    for step, label in (("wavelet", "wavelet"), ("restoring_force", "force")):
        if step in result.refusals:
            reasons.append((label, f"not identified: {result.refusals[step]}"))
    warning = uncorrected(result)
    if warning:
        reasons.append(("without", warning))
    return reasons


def uncorrected(result: Identification) -> str:
    """Return what the lag would have done to the restoring force's viscous damping, or ""."""
    with_, without = result.restoring_force, result.without_alignment
    if with_ is None or without is None or len(with_.damping) < 2 or len(without.damping) < 2:
        return ""
    right, wrong = with_.damping[1], without.damping[1]
    return (
        f"the lag corrected, the restoring force would have given mu_1 = {wrong.value:.3f} {wrong.unit} "
        f"instead of {right.value:.3f} {right.unit}"
    )


def next_steps(console: Console, folder: Path, result: Identification) -> None:
    """Print where everything is and what to do next: to look where the model fails, or at what was found."""
    console.print(Text(f" everything is in {folder}", style="dim"), soft_wrap=True)
    found = result.adequacy
    step = "report" if found is not None and found.adequate else "compare"
    console.print(next_line(step, folder), markup=False, soft_wrap=True)
