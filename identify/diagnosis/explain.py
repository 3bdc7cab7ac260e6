"""The explanation of a verdict, in two sentences with numbers."""

from collections.abc import Collection

import numpy as np

from identify.diagnosis.explain_prediction import (
    explain_confirmed,
    explain_driven,
    explain_unconfirmed,
)
from identify.effects.effect import Kind
from identify.effects.families import FAMILY_OF
from identify.evidence import price
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.fit import Fit
from identify.fitting.model_error import line_percent, motion_percent, removed_percent
from identify.formatting import (
    EXPLAINS_NOTHING,
    among,
    plain_name,
    quantities,
    quantity,
    sentence_case,
    share_words,
    three_figures,
    two_figures,
)
from identify.judging.beside_walk import law_sentence, walk_sentence
from identify.judging.suspect import Suspect, kinds_alike
from identify.judging.verdict import Judgement, why_not_enough
from identify.priors import LARGE
from identify.residual import floor_words, share_explained, times

_MOST_ALTERNATIVES = 4
"""Alternatives that are listed; of more the rest is counted."""

_LESSER_PART = 0.5
"""Share of the misfit's power up to which a sensor's fault that is named is the lesser part of it."""

_LOWERED = 2.0
"""Standard errors by which noise may lower a strength that is there."""

_MOST_OF_IT = 0.9
"""Share of what the model leaves that an effect explains where what is left, not the whole, has no name."""


def explain(
    baseline: Baseline,
    judgement: Judgement,
    suspects: tuple[Suspect, ...],
    findings: tuple[CorrectedFault, ...],
    settled: Baseline,
) -> str:
    """Explain the verdict, with numbers and the alternatives that remain."""
    verdict, together, shape = judgement.verdict, judgement.together, judgement.shape
    confirmation, too_small = judgement.confirmation, judgement.too_small
    if verdict == "nothing_missing" and too_small:
        small = next(s for s in suspects if s.kind == "physics" and s.plausible)
        return _sure_but_small(baseline, small, too_small)
    if verdict == "nothing_missing":
        return f"{_why_nothing(baseline, suspects, settled)} {_limit(baseline, suspects)}".strip()
    if verdict == "not_enough_data":
        return why_not_enough(baseline, settled.fit)
    top = suspects[0] if suspects else None
    if judgement.driven is not None:
        return explain_driven(judgement.driven, baseline.decays[0].window.unit)
    if verdict == "unconfirmed" and confirmation is not None:
        return explain_unconfirmed(confirmation, suspects, baseline.reduced(baseline.fit))
    if verdict == "unknown_effect" or top is None:
        return _unknown(baseline, judgement, suspects)
    if top.confirmed is not None and confirmation is not None:
        return explain_confirmed(
            tuple(s for s in suspects if s is top or s.effect.name in together), confirmation
        )
    if top.effect.name in {f.term.effect.name for f in findings}:
        return _corrected(baseline, top)
    first = _named(baseline, top, judgement, settled, kinds_alike(top, suspects))
    others = tuple(s for s in suspects[1:] if s.effect.name not in together)
    second = f"{_between(top)}{_alternatives(baseline, top, others)} It shows as: {top.effect.symptom}."
    if shape is not None and not baseline.adequate(settled.fit):
        rest = f"{three_figures(motion_percent(settled.fit))} % of the motion"
        if shape.coordinates:
            second += (
                f" A free-form force over {' and '.join(shape.coordinates)} explains {100.0 * shape.explained:.0f} % of "
                f"the residual ({rest})."
            )
        else:
            second += f" The residual ({rest}) follows no force in displacement, velocity or time."
    return f"{first} {second}"


def _sure_but_small(baseline: Baseline, top: Suspect, removed: float) -> str:
    """Explain that an effect is sure but smaller than the limit for a name, with the residual without it."""
    name, left = sentence_case(plain_name(top.effect.name)), three_figures(motion_percent(baseline.fit))
    return (
        f"{name} is significant, but it removes only {three_figures(removed)} % of the motion, too little to name it. "
        f"Without it the model leaves {left} % of the motion ({_times_the_noise(baseline.reduced(baseline.fit))})."
    )


def _why_nothing(baseline: Baseline, suspects: tuple[Suspect, ...], settled: Baseline) -> str:
    """Explain why nothing is missing: the floor is reached, with or without a small line, or the rest is too small."""
    left = _times_the_noise(baseline.reduced(baseline.fit))
    whole = f"{three_figures(motion_percent(baseline.fit))} % of the motion"
    floor = f"the noise floor ({floor_words(baseline.spread)})"
    line = next((s for s in suspects if _is_remarked_line(s, baseline, settled)), None)
    if line is not None:
        return (
            f"{_line_in_words(line)} With it the model leaves {_times_the_noise(line.error_after)}, without it {left}; "
            f"{floor} is a guess."
        )
    if not baseline.adequate(baseline.fit):
        known = "known" if baseline.floor_is_sure else "a guess"
        return (
            f"The model leaves {whole}, too little to name an effect. Yet it is {left}; {floor} is {known}."
        )
    counts = f"which is {floor}" if baseline.floor_is_sure else f"which counts as noise: {floor} is a guess"
    return f"The model leaves {left}, {counts}; no effect of the library lowers it by more than chance would."


def _is_remarked_line(suspect: Suspect, baseline: Baseline, settled: Baseline) -> bool:
    added = set(settled.fit.model.names) - set(baseline.fit.model.names)
    return suspect.effect.line and suspect.effect.name in added


def _line_in_words(line: Suspect) -> str:
    """Describe a sensor's line that is too small to be named."""
    frequency = next(value for value in line.parameters.values() if value.unit == "Hz")
    share = three_figures(line_percent(line.fit, line.term))
    what = f"The {line.term.channel} has a line at {quantity(frequency)}, {share} % of its motion"
    return f"{what}: too small to be named."


def _named(
    baseline: Baseline, top: Suspect, judgement: Judgement, settled: Baseline, kinds: Collection[Kind]
) -> str:
    together = judgement.together
    cause = "The missing effect is" if top.kind == "physics" else "A sensor is at fault:"
    if len(kinds) > 1:
        cause = "The best explanation is"
    what = f"{cause} {plain_name(top.effect.name)}{_where(top)}"
    if not top.strength_known:
        what += " (this record does not determine its strength)"
    before = times(baseline.reduced(baseline.fit))
    after = _times_the_noise(baseline.reduced(judgement.final) if together else top.error_after)
    if together:
        what += f" together with {among([plain_name(name) for name in together])}: together they lower"
    else:
        what += ": it lowers"
    channels, fits = ("motion", *baseline.fit.windows[0].channels[1:]), (baseline.fit, settled.fit)
    misfits = {c: [motion_percent(found, n) for found in fits] for n, c in enumerate(channels)}
    where = min(misfits, key=lambda c: misfits[c][1] / misfits[c][0])
    first, last = map(three_figures, misfits[where])
    return (
        f"{what} the residual from {first} to {last} % of the {where}, and from {before} to {after}; the noise floor is "
        f"{floor_words(baseline.spread)}.{_above_the_floor(baseline, judgement)}"
        f"{_hardly_any_of_it(baseline, top, settled)}"
    )


def _above_the_floor(baseline: Baseline, judgement: Judgement) -> str:
    """Say that what a name leaves is more than the noise at rest, and was weighed against laws; "" where it was not."""
    reached = not baseline.floor_is_sure or baseline.adequate(judgement.final)
    if reached or judgement.shape is not None or judgement.walk is not None:
        return ""
    left = _times_the_noise(baseline.reduced(judgement.final))
    return f" The residual is {left}, but neither a random walk nor a smooth law explains more of it than chance would."


def _hardly_any_of_it(baseline: Baseline, top: Suspect, settled: Baseline) -> str:
    """Warn that a sensor's fault is the smaller part of the residual, and only a guessed floor excuses the rest; or ""."""
    before, left = motion_percent(baseline.fit), motion_percent(settled.fit)
    share = (removed_percent(baseline.fit, settled.fit) / before) ** 2
    if top.kind == "physics" or baseline.floor_is_sure or left < LARGE or share > _LESSER_PART:
        return ""
    part = "hardly any" if share < EXPLAINS_NOTHING else share_words(share)
    return (
        f" What is named explains {part} of the residual: {three_figures(left)} % of the motion remains. Only a guessed "
        "noise floor accepts that, and a force may hide in it."
    )


def caution(baseline: Baseline, judgement: Judgement, named: Suspect | None, settled: Baseline) -> str:
    """Say what to keep in mind: that what is `named` explains little, that the rig drifts; "" for nothing."""
    releases = 1 + max(prepared.window.release for prepared in baseline.decays)
    removed = removed_percent(baseline.fit, settled.fit)
    small, force = "", named is not None and named.kind == "physics" and named.confirmed is None
    if force and removed < LARGE and releases == 1:
        small = (
            f"What is named removes only {three_figures(removed)} % of the motion: diagnose the record together with "
            "another release before you rely on the name."
        )
    drift = walk_sentence(judgement.walk, named=named is not None, releases=releases)
    law = law_sentence(judgement.decided) if named is not None and baseline.floor_is_sure else ""
    return " ".join(filter(None, (small, drift, law)))


def _between(top: Suspect) -> str:
    """Compare a law of a family with the nearest named effect; "" for any other effect."""
    family = FAMILY_OF.get(top.effect)
    if family is None:
        return ""
    exponent = top.parameters[family.free]
    nearest = family.nearest(exponent.value, top.baseline.fit.model.names)
    if nearest is None:
        return ""
    return (
        f"It behaves like {plain_name(nearest)} ({family.free} = {family.members[nearest]:g}), with {family.free} = "
        f"{quantity(exponent)}. "
    )


def _alternatives(baseline: Baseline, top: Suspect, others: tuple[Suspect, ...]) -> str:
    """Say which other effects would explain the record, those that are as good first."""
    if top.rivals:
        return f"This record does not distinguish it from {among([plain_name(name) for name in top.rivals], 'or')}."
    tried = [s for s in others if s.corrected is None]
    tied = [s for s in tried if s.plausible and baseline.adequate(s.fit)]
    if baseline.adequate(baseline.fit):
        return "The model reaches the floor without it, too: the named effect is small."
    if tied:
        return f"With less evidence, these would reach the floor, too: {_listed(tied)}."
    best = min((s for s in tried if s.plausible), key=lambda s: s.error_after, default=None)
    share = 0.0 if best is None else share_explained(baseline.reduced(baseline.fit), best.error_after)
    if best is None or share < EXPLAINS_NOTHING:
        return "No other effect explains any of it."
    return (
        f"The next best, {plain_name(best.effect.name)}, would explain {share_words(share)} of it and leave "
        f"{_times_the_noise(best.error_after)}."
    )


def _listed(suspects: list[Suspect]) -> str:
    first = sorted(suspects, key=lambda s: s.error_after)[:_MOST_ALTERNATIVES]
    shown = [f"{plain_name(s.effect.name)} ({_times_the_noise(s.error_after)})" for s in first]
    more = len(suspects) - len(shown)
    return "; ".join([*shown, f"{more} more"] if more else shown)


def _times_the_noise(reduced: float) -> str:
    """Return the rms of a residual as a multiple of the noise, from its reduced chi-square."""
    return f"{times(reduced)} times the noise"


def _left(baseline: Baseline, found: Fit, chi_square: float) -> str:
    """State a fit's residual in % of the motion and as a multiple of the noise; the multiple alone at a sure floor."""
    left = _times_the_noise(chi_square)
    return (
        left if baseline.floor_is_sure else f"{three_figures(motion_percent(found))} % of the motion ({left})"
    )


def _what_is_missing(baseline: Baseline, best: Suspect | None, suspects: tuple[Suspect, ...]) -> str:
    """State how much the model leaves, and the residual with each effect that explains most of it, or the best one."""
    before = baseline.reduced(baseline.fit)
    whole = _left(baseline, baseline.fit, before)
    floor = f"noise alone would leave {floor_words(baseline.spread)} times"
    if best is None:
        return f"Something is missing, and no effect can be named: the model leaves {whole}; {floor}."
    tried = [s for s in suspects if s.plausible and s.effect.kind == "physics"]
    most = sorted(
        (s for s in tried if share_explained(before, s.error_after) > _MOST_OF_IT),
        key=lambda s: s.error_after,
    )
    shown = most or [best]
    if baseline.adequate(shown[0].fit):
        rest = "None of these is confirmed" if len(shown) > 1 else "This is not confirmed"
    else:
        rest = "None of these comes down to the noise" if len(shown) > 1 else "That is still more than noise"
    leaves = _each_leaves(baseline, shown)
    return f"Something is missing: the model leaves {whole}. {leaves}; {floor}. {rest}."


def _each_leaves(baseline: Baseline, most: list[Suspect]) -> str:
    """State the residual with each suspect alone, the best first."""
    first, shown = most[0], most[1:_MOST_ALTERNATIVES]
    listed = [f"{plain_name(s.effect.name)} {times(s.error_after)} times" for s in shown]
    if len(most) > _MOST_ALTERNATIVES:
        more = len(most) - _MOST_ALTERNATIVES
        listed.append(f"{more} other{'s' if more > 1 else ''} nearly as little")
    others = f", {among(listed)}" if listed else ""
    left = _left(baseline, first.fit, first.error_after)
    return f"{sentence_case(plain_name(first.effect.name))} would leave {left}{others}"


def _unknown(
    baseline: Baseline,
    judgement: Judgement,
    suspects: tuple[Suspect, ...],
) -> str:
    """Explain that something is missing without a name: what named effects would leave, and a free form explains."""
    tried = [s for s in suspects if s.plausible and s.corrected is None]
    best, shape = None, judgement.shape
    if suspects and suspects[0].claimed:
        best = min(tried, key=lambda s: s.error_after, default=suspects[0])
    first = _what_is_missing(baseline, best, suspects)
    by_curves = not baseline.floor_is_sure and baseline.decays[0].window.force is None
    if by_curves and judgement.confirmation is None:
        first += (
            " One record of fewer than about twelve cycles is too short to predict its small amplitudes from its large "
            "ones, so no name is confirmed: diagnose it together with another release."
        )
    if best is not None and baseline.adequate(best.fit):
        return first
    if shape is None or not shape.coordinates:
        return f"{first} No smooth force in displacement, velocity or time alone explains it."
    peak = shape.shapes[0]
    at = int(np.argmax(np.abs(peak.force) / np.maximum(peak.std, 1e-300)))
    unit = baseline.fit.windows[0].unit
    return (
        f"{first} A free-form force explains {100.0 * shape.explained:.0f} % of the rest; it depends on "
        f"{' and '.join(shape.coordinates)} and is clearest near {peak.position[at]:.3g} {peak.unit} "
        f"({peak.force[at]:+.2g} {unit}/s^2{peak.where and f' {peak.where}'})."
    )


def _corrected(baseline: Baseline, top: Suspect) -> str:
    numbers = ", ".join(quantities(top.parameters))
    before, after = times(baseline.reduced(baseline.fit)), _times_the_noise(top.error_after)
    return (
        f"A sensor is at fault: {plain_name(top.effect.name)}{_where(top)} ({numbers}); without allowing for it "
        f"the residual is {before}, with it {after}; the noise floor is {floor_words(baseline.spread)}. "
        f"Once it is corrected the forces are not affected; {top.effect.confirming_test}."
    )


def _where(suspect: Suspect) -> str:
    return f" in the {suspect.term.channel} channel" if suspect.term.channel else ""


def _limit(baseline: Baseline, suspects: tuple[Suspect, ...]) -> str:
    """State the strengths from which on something would have been claimed, even where noise lowers what is seen."""
    words = []
    for suspect in suspects:
        if not suspect.effect.shows_detection_limit:
            continue
        strength = suspect.parameters.get(suspect.effect.strength.name)
        if strength is not None and np.isfinite(strength.std):
            needed = np.log(len(suspects) / baseline.alpha) + price(
                baseline.fit, suspect.fit, baseline.scales
            )
            limit = two_figures((np.sqrt(2.0 * needed) + _LOWERED) * strength.std)
            words.append(f"{plain_name(suspect.effect.name)} beyond ±{limit} {strength.unit}")
    return f"The data would have shown {' or '.join(words)}." if words else ""
