"""Diagnosis: which effect a model lacks, how sure that is, and what cannot be told apart."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from identify.arrays import Array
from identify.diagnosis.explain import explain
from identify.diagnosis.next_experiment import next_experiment
from identify.diagnosis.nonparametric_force import NonparametricForce, nonparametric_force
from identify.diagnosis.null_distribution import NullDistribution
from identify.diagnosis.rest_evidence import at_rest
from identify.diagnosis.search import Pair, chances, pairs, singles
from identify.diagnosis.suspects import Candidate
from identify.effects.effect import Effect, Kind
from identify.effects.library import LIBRARY
from identify.estimate import Estimate
from identify.fitting.baseline import Baseline, fit_baseline, force_along_motion, refit_at_floor
from identify.fitting.corrected_faults import CorrectedFault, corrected_faults
from identify.fitting.fit import Fit, fit
from identify.fitting.segments import segments
from identify.model.model import Model, Term, base_model
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay

Verdict = Literal["missing_effect", "sensor_fault", "nothing_missing", "unknown_effect", "not_enough_data"]

ALPHA = 0.02
"""Probability of claiming an effect where there is none; the promise is 5 %."""

_ALPHA_GUESSED = 2e-4
"""The same where the floor could only be guessed: on such records nothing weak is claimed."""

_APART = 4.6
"""Nats of evidence (odds of 100 to 1) below which two suspects count as not told apart."""

_DECISIVE = 12.0
"""Nats of evidence below which a force is not claimed while a sensor is known to be faulty: mend that first."""

_FREE_FORM_EXPLAINS = 0.3
_FEWEST_CYCLES = 5.0
_HELD_OUT = 3


@dataclass(frozen=True, eq=False)
class Suspect:
    """One effect that the model may lack.

    `evidence` is in nats: how much better than by chance its refit explains the readings. `p_value` is the probability
    that chance gives any suspect of the library as good a reason. `held_out_gain` is the drop of chi-square on cycles
    that were not fitted, None when it was not asked. `confusable_with` are effects that this record does
    not tell from it, and effects that it is known to be mistaken for.
    """

    effect: Effect
    term: Term
    error_after: float
    evidence: float
    p_value: float
    parameters: dict[str, Estimate]
    confusable_with: tuple[str, ...]
    held_out_gain: float | None
    fit: Fit | None
    plausible: bool = True

    @property
    def kind(self) -> Kind:
        """physics or sensor."""
        return self.effect.kind


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What a model lacks.

    `start` is the model as fitted, with its floor. `together` names a second effect when it takes two to reach
    the floor. `findings` are sensors' faults that are corrected in every fit but ought to be mended. `final` is
    the fit with what was found, against the floor that its own residual shows. `shape` is the free form, when
    something is missing that has no name.
    """

    start: Baseline
    verdict: Verdict
    suspects: tuple[Suspect, ...]
    together: tuple[str, ...]
    findings: tuple[CorrectedFault, ...]
    final: Fit
    shape: NonparametricForce | None
    explanation: str
    next_experiment: str

    @property
    def named(self) -> tuple[str, ...]:
        """The effects that the verdict names."""
        if self.verdict not in ("missing_effect", "sensor_fault"):
            return ()
        return (self.suspects[0].effect.name, *self.together)


def diagnose(
    decays: tuple[PreparedDecay, ...],
    model: Model | None = None,
    *,
    library: tuple[Effect, ...] = LIBRARY,
    known: dict[str, float] | None = None,
) -> Diagnosis:
    """Return what a model (stiffness, Coulomb and viscous friction unless given) lacks on one or more releases."""
    decays = tuple(segment for prepared in decays for segment in segments(prepared))
    start = fit_baseline(decays, model or base_model(), known)
    tried = singles(start, library)
    chance = chances(start, library)
    dispersion = _dispersion(start, tried)
    faults = tuple(
        f for f in corrected_faults(start.decays, start.fit) if f.term.effect.name not in start.fit.model
    )
    ranked = _rank(start, tried, chance, dispersion)
    judgement = _judge(start, ranked, faults, library)
    verdict, together, final, shape = judgement.verdict, judgement.together, judgement.final, judgement.shape
    suspects = _suspects(start, judgement, faults)
    settled = refit_at_floor(start.decays, final) if final is not start.fit else start
    final = settled.fit
    if suspects and suspects[0].fit is judgement.final:
        suspects = (replace(suspects[0], error_after=settled.reduced(final)), *suspects[1:])
    suspects = _with_held_out(start, suspects)
    cycles = len(start.fit.windows[0]) / start.fit.windows[0].rate * start.fit.frequency / (2.0 * np.pi)
    if cycles < _FEWEST_CYCLES and verdict != "sensor_fault":
        verdict = "not_enough_data"
    findings = tuple(f for f in faults if _significant(f))
    explanation = explain(start, verdict, suspects, together, findings, final, shape)
    return Diagnosis(
        start,
        verdict,
        suspects,
        together,
        findings,
        final,
        shape,
        explanation,
        next_experiment(start, verdict, suspects),
    )


@dataclass(frozen=True, eq=False)
class _Ranked:
    candidate: Candidate
    evidence: float
    p_value: float


def _dispersion(start: Baseline, tried: tuple[Candidate, ...]) -> float:
    """Return by how much a misfit that nothing explains widens chance: 1 where the best refit reaches a sure floor."""
    best = min((c.fit for c in tried if c.plausible), key=lambda found: found.chi_square, default=start.fit)
    if start.adequate(best) and start.floor_is_sure:
        return 1.0
    lengths = []
    for i, window in enumerate(best.windows):
        for channel in window.channels:
            residual = np.where(window.used[channel], best.residual(channel, i), 0.0)
            lengths.append(_correlation_length(residual))
    return max(1.0, best.reduced * float(np.mean(lengths)))


def _correlation_length(values: Array) -> float:
    """Return how many readings count as one, from the autocorrelation up to its first zero."""
    n = len(values)
    power = np.abs(np.fft.rfft(values - values.mean(), 2 * n)) ** 2
    correlation = np.fft.irfft(power)[:n]
    if correlation[0] <= 0.0:
        return 1.0
    correlation = correlation / correlation[0]
    below = np.flatnonzero(correlation < 0.0)
    return float(1.0 + 2.0 * correlation[1 : below[0] if len(below) else n].sum())


def _rank(
    start: Baseline, tried: tuple[Candidate, ...], chance: NullDistribution, dispersion: float
) -> tuple[_Ranked, ...]:
    ranked = []
    for candidate in tried:
        drop = candidate.gain / dispersion
        evidence = chance.surprise(candidate.name, drop) + at_rest(start.decays, candidate)
        p_value = chance.p_value(candidate.name, drop) if evidence > 0.0 else 1.0
        ranked.append(_Ranked(candidate, evidence, p_value))
    return tuple(sorted(ranked, key=_order))


def _order(entry: _Ranked) -> tuple[int, float]:
    """Put plausible suspects that chance cannot explain first, then implausible ones, then the rest."""
    tier = 2 if entry.p_value >= ALPHA else 0 if entry.candidate.plausible else 1
    return tier, -entry.evidence


def _significant(fault: CorrectedFault) -> bool:
    return fault.drop > 12.0


@dataclass(frozen=True, eq=False)
class _Judgement:
    """What is to be said; `corrected` tells that a fault which every fit corrects decides, not a suspect that was tried."""

    verdict: Verdict
    ranked: tuple[_Ranked, ...]
    together: tuple[str, ...]
    final: Fit
    shape: NonparametricForce | None
    corrected: bool = False


def _judge(
    start: Baseline,
    ranked: tuple[_Ranked, ...],
    faults: tuple[CorrectedFault, ...],
    library: tuple[Effect, ...],
) -> _Judgement:
    top = ranked[0] if ranked else None
    if top is None or top.p_value >= (ALPHA if start.floor_is_sure else _ALPHA_GUESSED):
        if not start.adequate(start.fit):
            return _Judgement("unknown_effect", ranked, (), start.fit, _free(start, start.fit))
        faulty = any(_significant(f) for f in faults)
        return _Judgement(
            "sensor_fault" if faulty else "nothing_missing", ranked, (), start.fit, None, faulty
        )
    best = top.candidate
    if (
        best.term.effect.kind == "physics"
        and top.evidence < _DECISIVE
        and any(_significant(f) for f in faults)
    ):
        return _Judgement("sensor_fault", ranked, (), start.fit, None, corrected=True)
    if start.adequate(best.fit):
        if not best.plausible:
            return _Judgement("unknown_effect", ranked, (), best.fit, _free(start, start.fit))
        return _Judgement(_kind_of(best), ranked, (), best.fit, None)
    two = pairs(start, tuple(entry.candidate for entry in ranked), library)
    together = two[0] if two and two[0].plausible else None
    if together is not None and start.adequate(together.second.fit):
        return _of_pair(ranked, together, None)
    final = together.second.fit if together is not None else best.fit
    shape = _free(start, final)
    if shape.explained > _FREE_FORM_EXPLAINS or start.floor_is_sure or not best.plausible:
        return _Judgement("unknown_effect", ranked, (), final, _free(start, best.fit))
    if together is not None:
        return _of_pair(ranked, together, shape)
    return _Judgement(_kind_of(best), ranked, (), best.fit, shape)


def _of_pair(ranked: tuple[_Ranked, ...], pair: Pair, shape: NonparametricForce | None) -> _Judgement:
    """Return the judgement that names a pair, the one that is better alone first."""
    names = (pair.first.name, pair.second.name)
    lead = next(entry for entry in ranked if entry.candidate.name in names)
    rest = tuple(entry for entry in ranked if entry is not lead)
    other = tuple(name for name in names if name != lead.candidate.name)
    return _Judgement(_kind_of(lead.candidate), (lead, *rest), other, pair.second.fit, shape)


def _kind_of(candidate: Candidate) -> Verdict:
    return "missing_effect" if candidate.term.effect.kind == "physics" else "sensor_fault"


def _free(start: Baseline, found: Fit) -> NonparametricForce:
    largest = max(start.decays, key=lambda prepared: prepared.amplitude)
    return nonparametric_force(largest, force_along_motion(largest, found))


def _suspects(
    start: Baseline, judgement: _Judgement, faults: tuple[CorrectedFault, ...]
) -> tuple[Suspect, ...]:
    """Return the suspects in order: first what the verdict names, if it names any."""
    ranked, entries = judgement.ranked, []
    for entry in ranked:
        candidate = entry.candidate
        close = [
            other.candidate.name
            for other in ranked
            if other is not entry and abs(other.evidence - entry.evidence) < _APART and other.p_value < ALPHA
        ]
        known = [n for n in candidate.term.effect.confusable_with if n not in close]
        entries.append(
            Suspect(
                candidate.term.effect,
                candidate.term,
                start.reduced(candidate.fit),
                entry.evidence,
                entry.p_value,
                candidate.fit.of(candidate.term),
                (*close, *known),
                None,
                candidate.fit,
                candidate.plausible,
            )
        )
    sensors = []
    for fault in faults:
        without = sum(f.drop for f in faults if f is not fault)
        readings = sum(f.readings for f in faults if f is not fault)
        sensors.append(
            Suspect(
                fault.term.effect,
                fault.term,
                (start.fit.chi_square + without) / max(start.fit.degrees + readings, 1),
                0.5 * fault.drop,
                float(np.exp(-0.5 * max(fault.drop - 4.0, 0.0))),
                fault.parameters,
                fault.term.effect.confusable_with,
                None,
                start.fit,
            )
        )
    sensors.sort(key=lambda suspect: -suspect.evidence)
    if judgement.corrected:
        return tuple(sensors + entries)
    named = entries[:1] if judgement.verdict in ("missing_effect", "sensor_fault") else []
    claimed = named + [e for e in entries[len(named) :] if e.p_value < ALPHA]
    rest = [e for e in entries[len(named) :] if e.p_value >= ALPHA]
    return tuple(
        claimed + [s for s in sensors if s.evidence > 6.0] + rest + [s for s in sensors if s.evidence <= 6.0]
    )


def _with_held_out(start: Baseline, suspects: tuple[Suspect, ...]) -> tuple[Suspect, ...]:
    """Ask the first few suspects what they predict of cycles they were not fitted to."""
    base = _held_out_error(start.fit, start.fit.windows)
    asked = []
    for rank, suspect in enumerate(suspects):
        if (
            rank < _HELD_OUT
            and suspect.fit is not None
            and suspect.fit is not start.fit
            and suspect.p_value < ALPHA
        ):
            gain = base - _held_out_error(suspect.fit, start.fit.windows)
            suspect = replace(suspect, held_out_gain=gain)
        asked.append(suspect)
    return tuple(asked)


def _held_out_error(found: Fit, windows: tuple[FitWindow, ...]) -> float:
    """Return chi-square on every second pair of cycles, of a fit to the others."""
    kept, held = [], []
    for window in windows:
        cycle = np.floor(window.clock * found.frequency / (2.0 * np.pi)).astype(int) % 2 == 0
        kept.append(window.with_(used={c: m & cycle for c, m in window.used.items()}))
        held.append(window.with_(used={c: m & ~cycle for c, m in window.used.items()}))
    values = dict(zip(found.names, found.theta.tolist(), strict=True))
    refit = fit(found.model, tuple(kept), values, found.frequency, tolerance=1.0)
    total = 0.0
    for i, window in enumerate(held):
        for channel in window.channels:
            used = window.used[channel]
            off = (window.readings[channel] - refit.predicted[i][channel])[used] / window.sigma[channel]
            total += float(off @ off)
    return total
