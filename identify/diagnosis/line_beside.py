"""A sensor's line beside a force: hum that keeps a force from a floor that could only be guessed.

Hum that stands between the harmonics has nothing to do with the motion, but it fills the misfit that a force must bring
down to the floor. So what the best force leaves is asked for a line of a sensor. If there is one, the model gets it, noise
is seen again in what both leave, and all suspects are tried again.
"""

from dataclasses import dataclass, replace

import numpy as np

from identify.diagnosis.ranking import Ranked, rank
from identify.diagnosis.search import singles
from identify.diagnosis.suspects import residual_lines
from identify.diagnosis.verdict import Judgement
from identify.effects.effect import Effect
from identify.evidence.evidence import nothing
from identify.evidence.marginal_likelihood import evidence
from identify.fitting.baseline import Baseline, with_noise_beside
from identify.fitting.fit import fit
from identify.fitting.initial_values import scales_of
from identify.fitting.misfit_errors import misfit_density
from identify.fitting.noise_colour import may_be_hum
from identify.priors import DOUBT_AT_A_GUESS


@dataclass(frozen=True, eq=False)
class LineBeside:
    """A sensor's line, the model as fitted with it, and the suspects of that model."""

    line: Ranked
    baseline: Baseline
    ranked: tuple[Ranked, ...]

    def named_with(self, judgement: Judgement) -> Judgement:
        """Return what was judged beside the line with the line named too."""
        name = self.line.candidate.name
        return replace(
            judgement,
            ranked=(judgement.ranked[0], self.line, *judgement.ranked[1:]),
            together=(*judgement.together, name),
        )


def line_beside(
    baseline: Baseline, ranked: tuple[Ranked, ...], library: tuple[Effect, ...]
) -> LineBeside | None:
    """Return the line that a sensor has beside the best force, with the suspects beside it.

    None where no force is claimed, where one reaches the floor, or where what it leaves holds no line of a sensor.
    """
    force = next((e for e in ranked if e.candidate.plausible and _is_steady_force(e)), None)
    if force is None or not force.claimed or _first_reaches(baseline, ranked):
        return None
    lines = tuple(e for e in library if e.line and e.kind == "sensor" and e.name not in baseline.fit.model)
    line = _line_behind(replace(baseline, fit=force.candidate.fit), lines) if lines else None
    if line is None:
        return None
    best = line.candidate
    model = baseline.fit.model.plus(best.term)
    begun = best.fit.point | baseline.fit.point
    usual = fit(model, baseline.fit.windows, begun, baseline.fit.frequency, near=True)
    beside = with_noise_beside(replace(baseline, fit=usual), best.fit)
    names = {entry.candidate.name for entry in ranked} - {best.name}
    tried = tuple(effect for effect in library if effect.name in names)
    return LineBeside(line, beside, rank(beside, singles(beside, tried)))


def _line_behind(behind: Baseline, lines: tuple[Effect, ...]) -> Ranked | None:
    """Return the line of a sensor in what a fit leaves; None where none stands clear of the residual around it and lasts."""
    found = next((c for c in singles(behind, lines) if c.plausible), None)
    if found is None:
        return None
    values = found.fit.of(found.term, 0)
    line = values[next(p.name for p in found.term.effect.parameters if p.unit == "Hz")].value
    if not may_be_hum(behind.fit, found.term.channel, line):
        return None
    density = misfit_density(found.fit, 2.0 * np.pi * line, found.term.channel)
    scales = scales_of(behind.decays[0], residual_lines(behind.fit))
    nats = evidence(behind.fit, found.fit, scales, max(density, 1.0))
    return Ranked(found, nats, True) if nothing([nats]) < DOUBT_AT_A_GUESS else None


def _is_steady_force(entry: Ranked) -> bool:
    """Whether a suspect is a force that the motion makes: a line of a force is no better known than that of a sensor."""
    return entry.candidate.term.is_force and not entry.candidate.term.effect.line


def _first_reaches(baseline: Baseline, ranked: tuple[Ranked, ...]) -> bool:
    return _is_steady_force(ranked[0]) and baseline.adequate(ranked[0].candidate.fit)
