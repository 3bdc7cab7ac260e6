"""The suspects as they are listed: what the verdict names first, faults that every fit corrects among them."""

from identify.curves.confirmation import Confirmation, ConfirmedEffect
from identify.diagnosis.ranking import Ranked, rivals_of
from identify.diagnosis.suspect import Suspect
from identify.diagnosis.verdict import Judgement
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault, unnamed_faults
from identify.fitting.model_error import motion_percent

_WORTH_A_MENTION = 6.0
"""Nats from which on a fault that every fit corrects is listed before suspects that are not claimed."""


def listed_suspects(baseline: Baseline, judgement: Judgement, settled: Baseline) -> tuple[Suspect, ...]:
    """Return the suspects in order, first what the verdict names, if it names any; `settled` is the fit with that."""
    faults = unnamed_faults(baseline.decays, baseline.fit)
    entries = [_suspect(baseline, entry, judgement, settled) for entry in judgement.ranked]
    sensors = sorted(
        (_corrected(baseline, fault, faults) for fault in faults), key=lambda suspect: -suspect.evidence
    )
    if judgement.corrected:
        return (*sensors, *entries)
    named = 1 if judgement.verdict in ("missing_effect", "sensor_fault") else 0
    first = [e for rank, e in enumerate(entries) if rank < named or e.claimed]
    rest = [e for e in entries if e not in first]
    strong = [s for s in sensors if s.evidence > _WORTH_A_MENTION]
    weak = [s for s in sensors if s.evidence <= _WORTH_A_MENTION]
    return (*first, *strong, *rest, *weak)


def _suspect(baseline: Baseline, entry: Ranked, judgement: Judgement, settled: Baseline) -> Suspect:
    candidate = entry.candidate
    is_final = candidate.fit is judgement.final
    named = judgement.together and (entry is judgement.ranked[0] or candidate.name in judgement.together)
    confirmed = _confirmed(judgement.confirmation, candidate.name)
    return Suspect(
        effect=candidate.term.effect,
        term=candidate.term,
        error_after=settled.reduced(settled.fit) if is_final else baseline.reduced(candidate.fit),
        motion_after=motion_percent(settled.fit if is_final else candidate.fit),
        evidence=entry.evidence,
        claimed=entry.claimed,
        baseline=baseline,
        fit=candidate.fit,
        last=settled.fit if named or is_final else candidate.fit,
        rivals=rivals_of(entry, judgement.ranked) if confirmed is None else confirmed.rivals,
        plausible=candidate.plausible,
        confirmed=confirmed,
    )


def _confirmed(found: Confirmation | None, name: str) -> ConfirmedEffect | None:
    return next((e for e in found.effects if e.name == name), None) if found is not None else None


def _corrected(baseline: Baseline, fault: CorrectedFault, faults: tuple[CorrectedFault, ...]) -> Suspect:
    """Return a fault that every fit corrects as a suspect: what the model would leave with this one named in it."""
    others = [f for f in faults if f is not fault]
    chi_square = baseline.fit.chi_square + sum(f.drop for f in others)
    return Suspect(
        effect=fault.term.effect,
        term=fault.term,
        error_after=chi_square / max(baseline.fit.degrees + sum(f.readings for f in others), 1),
        motion_after=None,
        evidence=0.5 * fault.surplus,
        claimed=fault.p_value < baseline.alpha,
        baseline=baseline,
        fit=baseline.fit,
        last=baseline.fit,
        corrected=fault.parameters,
    )
