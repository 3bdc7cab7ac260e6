"""Diagnosis: which effect a model lacks, how sure that is, and which effects are not distinguishable."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain

from identify.curves.confirm import Curves
from identify.curves.confirmation import Confirmation
from identify.curves.laid_over import Law
from identify.diagnosis.explain import caution, explain
from identify.diagnosis.ladder import Ladder, Progress, add_found, step_of, without_needless_effects
from identify.diagnosis.other_modes import OtherMode, modes_sentence, other_modes
from identify.diagnosis.shares import AmplitudeShares, shares, shares_summary
from identify.effects.effect import Effect
from identify.effects.library import LIBRARY
from identify.evidence import Evidence
from identify.fitting.baseline import Baseline, fit_baseline, refit_at_floor, with_floor
from identify.fitting.corrected_faults import CorrectedFault, unnamed_faults
from identify.fitting.fit import Fit
from identify.fitting.harmonic_residual import HarmonicResidual
from identify.fitting.initial_values import scales_of
from identify.fitting.model_error import ModelError, errors_of, may_hide_anything
from identify.fitting.random_walk import RandomWalk
from identify.fitting.segments import largest_first, prepared_of, segments_of, what_was_used
from identify.formatting import plain_name, quantities, sentence_case
from identify.free_decay import FreeDecay
from identify.judging.judgement import judge, large_enough, listed_suspects
from identify.judging.nonparametric_force import NonparametricForce
from identify.judging.ranking import rank, with_laws_between
from identify.judging.releases_differ import (
    ReleaseValue,
    carried,
    on_second_thought,
    release_values,
    shared_where_alike,
    spread_sentence,
    where_releases_differ,
)
from identify.judging.suspect import Suspect
from identify.judging.suspects import InPlace, candidate_terms, singles
from identify.judging.verdict import Judgement, Verdict, headline_of, too_few_cycles
from identify.model.model import Model, base_model
from identify.planning.hypotheses import Hypothesis, hypotheses_of, what_can_hide
from identify.planning.next_release import Limits, NextRelease, next_release
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.residual import times
from identify.summary import Summarised, Summary

_MOST_STEPS = 5
_SHOWN = 6
_NO_RELEASE: tuple[Verdict, ...] = ("not_enough_data", "driven")
_STOPS: dict[Verdict, str] = {
    "nothing_missing": "the noise floor is reached: no effect of the library lowers the error by more than noise explains",
    "unknown_effect": "something is missing, and no effect can be named; see the free form",
    "unconfirmed": "no effect of the library predicts the residual",
    "driven": "the motion is driven: a free decay is needed to name a force",
    "not_enough_data": "the record is too short to distinguish more effects",
}
_EXPLAINED: tuple[Verdict, ...] = ("missing_effect", "sensor_fault", "nothing_missing")


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Summarised):
    """The result of a diagnosis: what a model lacks.

    `baseline` is the fitted model with its noise floor. `suspects` come in order, what the verdict names first. `named`
    are the effects that the verdict names, several where it takes several. `findings` are sensors' faults that are
    corrected in every fit but ought to be mended. `judged` is the fit with what was found, against the baseline's floor
    as all suspects are, and `final` the same against the floor that its own residual shows. `shape` is the free-form
    force, when something is missing that has no name. `confirmation` is what the curves of the decay predict, None where
    they were not asked. `decays` are the whole releases, the largest first. `shares` say what each effect of the final
    model does at the largest and at the smallest amplitude; none where something without a name is missing. `harmonics`
    says, near a floor that is a guess, whether the residual stands at the motion's harmonics; None where the floor itself
    decides. `modes` are other modes of the structure that the residual shows. Forces that remove less than `worth` % of
    the motion were not named: `too_small` is what such a one removes, 0 where there is none. `walk` is a random walk of
    spring and damper that remains beside the name or, without one, explains all of the misfit. `decided` is what the
    table weighed and decided, for each of several effects its own, empty where it was not asked. `caution` is what to
    keep in mind. `places` say what was tried in the place of each of several names.
    """

    baseline: Baseline
    verdict: Verdict
    suspects: tuple[Suspect, ...]
    named: tuple[str, ...]
    findings: tuple[CorrectedFault, ...]
    judged: Fit
    final: Fit
    shape: NonparametricForce | None
    explanation: str
    library: tuple[Effect, ...] = field(default_factory=lambda: LIBRARY)
    confirmation: Confirmation | None = None
    decays: tuple[PreparedDecay, ...] = ()
    shares: tuple[AmplitudeShares, ...] = ()
    harmonics: HarmonicResidual | None = None
    modes: tuple[OtherMode, ...] = ()
    worth: float = 0.0
    too_small: float = 0.0
    walk: RandomWalk | None = None
    decided: tuple[Evidence, ...] = ()
    caution: str = ""
    places: tuple[InPlace, ...] = ()

    @property
    def error_with_named(self) -> ModelError:
        """The errors with what is named, its chi-square in the noise by which all suspects were judged."""
        found = errors_of(replace(self.baseline, fit=self.final))
        return replace(found, chi_square=self.baseline.reduced(self.judged))

    @cached_property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The hypotheses that are still open, the likeliest first, weighed when asked for."""
        walk = None if self.named else self.walk
        seen = self.confirmation.undecided if self.confirmation and self.verdict == "unconfirmed" else {}
        undecided = frozenset(chain(*seen.values()))
        return hypotheses_of(
            self.baseline, self.suspects, self.named, self.final, self.shape, walk, self.places, undecided
        )

    @cached_property
    def next_release(self) -> NextRelease | None:
        """The release that would distinguish the hypotheses best, computed when asked for; None where a release cannot."""
        return None if self.verdict in _NO_RELEASE else next_release(self.baseline.decays, self.hypotheses)

    @cached_property
    def next_experiment(self) -> str:
        """What to record next, in a sentence."""
        return _next_experiment(self.baseline, self.verdict, self.suspects, self.next_release)

    def next_within(self, limits: Limits) -> NextRelease | None:
        """Choose the most informative release that a rig allows; None where no release tells anything.

        It tests what is named, and what can hide beside it.
        """
        decays, lead = self.baseline.decays, self.hypotheses[0]
        hiding = what_can_hide(decays, lead, self.library) if lead.names else ()
        return next_release(decays, self.hypotheses, limits, hiding)

    @property
    def of_releases(self) -> tuple[ReleaseValue, ...]:
        """The linear spring and damper of each release, where they differ; empty where all share them."""
        return release_values(self.baseline.stated(self.final))

    @property
    def named_suspects(self) -> tuple[Suspect, ...]:
        """The suspects that the verdict names, in its order."""
        found = {suspect.effect.name: suspect for suspect in reversed(self.suspects)}
        return tuple(found[name] for name in self.named)

    @property
    def laws(self) -> tuple[Law, ...]:
        """The usual model, the one with what is named, and the rivals of a single name, to be laid over `decay_curves`."""
        laws = [Law.of("usual model", "usual", self.baseline.fit)]
        if self.named:
            laws.append(Law.of(" + ".join(self.named), "named", self.final))
        rivals = self.suspects[0].rivals if len(self.named) == 1 else ()
        fits = {suspect.effect.name: suspect.fit for suspect in self.suspects}
        return (*laws, *(Law.of(name, "rival", fits[name]) for name in rivals if name in fits))

    def refine(self, progress: Progress = lambda step, words: None) -> Ladder:
        """Add what is named and diagnose again until nothing with a name is missing; return the ladder.

        Effects that are no longer needed once others have come are taken out, and at the end those of the model to begin
        with, beyond the usual ones, that explain nothing. `progress` is called with each new step and a sentence.
        """
        steps, found = [step_of(self.baseline)], self
        own = set(steps[0].effects)
        progress(steps[0], "the model to begin with")
        while not (reason := found._reason_to_stop(len(steps))):
            for suspect in found.named_suspects:
                step = add_found(steps[-1], suspect, found.final)
                if step.fit.chi_square >= steps[-1].fit.chi_square:
                    return Ladder(tuple(steps), f"{step.added} does not lower the error", found.verdict)
                steps.append(step)
                progress(step, f"added {step.added}")
            for step in without_needless_effects(steps[-1], own | {steps[-1].added}):
                steps.append(step)
                progress(step, f"removed {step.removed}: it is no longer needed")
            top = steps[-1].fit
            known = top.point
            found = diagnose(self.decays, top.model, library=self.library, known=known, worth=self.worth)
        named = {step.added for step in steps}
        for step in without_needless_effects(steps[-1], named | set(base_model().names)):
            steps.append(step)
            progress(step, f"removed {step.removed}: it explains nothing")
        return Ladder(tuple(steps), reason, found.verdict)

    def _reason_to_stop(self, steps: int) -> str:
        if self.verdict == "nothing_missing" and (
            self.too_small or not self.baseline.adequate(self.baseline.fit)
        ):
            return "the residual is too small a part of the motion to name an effect"
        if self.verdict == "unknown_effect" and self.walk is not None:
            return "no law is needed for the residual: a random walk of spring and damper explains it"
        if self.verdict in _STOPS:
            return _STOPS[self.verdict]
        many = f"{_MOST_STEPS} effects were added; with more, a model would fit any record"
        return many if steps > _MOST_STEPS else ""

    def brief(self) -> Summary:
        """Summarize the verdict, its reason, the first few suspects, and what each effect does."""
        rows = [
            (
                suspect.effect.name,
                times(suspect.error_after),
                f"{suspect.evidence:.0f}",
                "yes" if suspect.claimed else "no",
            )
            for suspect in self.suspects[:_SHOWN]
        ]
        undecided = bool(self.confirmation and self.confirmation.undecided)
        rivals = self.suspects[0].rivals if self.named else ()
        kinds = {suspect.effect.name: suspect.kind for suspect in self.suspects if suspect.plausible}
        return Summary(
            headline_of(self.verdict, self.named, rivals, kinds, undecided=undecided),
            (
                self.explanation,
                *(
                    f"{sentence_case(plain_name(one.effect.name))}: {', '.join(quantities(one.parameters))}."
                    for one in self.named_suspects
                    if one.strength_known
                ),
                *(f"Used: {decay.use.words}." for decay in self.decays if decay.use is not None),
                what_was_used(self.baseline.decays),
                modes_sentence(self.modes),
                f"Record next: {self.next_experiment}",
            ),
            ("suspect", "times noise after", "evidence (nats)", "claimed"),
            rows,
            shares_summary(self.shares),
        )


def diagnose(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
    model: Model | None = None,
    *,
    library: tuple[Effect, ...] | None = None,
    known: dict[str, float] | None = None,
    worth: float = 0.0,
    progress: Callable[[str], None] = lambda words: None,
) -> Diagnosis:
    """Diagnose what a model lacks on one release, or on several that share their physics.

    The model is stiffness, Coulomb and viscous friction unless given; `known` are values to begin the fit from, by
    unknown's name; `library` are the effects that are tried, LIBRARY unless given. No force is named that removes less than
    `worth` % of the motion, however sure it is; what the curves name removes half a percent at least. `progress`
    gets each step in words, counted where the number of fits is known. Raises NotIdentifiable when a release
    holds too little to fit anything.
    """
    library = LIBRARY if library is None else library
    given = prepared_of(decays)
    whole = tuple(given[i] for i in largest_first(given))
    first = fit_baseline(segments_of(whole), model or base_model(), known)
    whole = tuple(with_floor(prepared, first.spread) for prepared in whole)
    baseline, judgement = _searched(first, whole, library, progress)
    judgement = large_enough(baseline, judgement, worth)
    whole = whole if baseline is first else carried(whole, baseline)  # other noise, another floor
    settled = _settled(baseline, judgement)
    suspects = listed_suspects(baseline, judgement, settled)
    verdict = judgement.verdict
    few = too_few_cycles(baseline) and verdict != "sensor_fault"
    if few or (verdict == "nothing_missing" and may_hide_anything(settled, settled.fit)):
        verdict = "not_enough_data"
        judgement = replace(judgement, verdict=verdict, walk=None)
    findings = _findings(settled)
    harmonics = baseline.harmonics(judgement.final) if verdict != "not_enough_data" else None
    named = (
        (suspects[0].effect.name, *judgement.together)
        if verdict in ("missing_effect", "sensor_fault")
        else ()
    )
    warned = caution(baseline, judgement, suspects[0] if named else None, settled)
    said = (
        explain(baseline, judgement, suspects, findings, settled),
        warned,
        harmonics.sentence if harmonics else "",
        spread_sentence(settled.stated(settled.fit)) if release_values(settled.fit) else "",
    )
    return Diagnosis(
        baseline=baseline,
        verdict=verdict,
        suspects=suspects,
        named=named,
        findings=findings,
        judged=judgement.final,
        final=settled.fit,
        shape=judgement.shape,
        explanation=" ".join(filter(None, said)),
        library=library,
        confirmation=judgement.confirmation,
        decays=whole,
        shares=shares(whole, baseline.stated(settled.fit)) if verdict in _EXPLAINED else (),
        harmonics=harmonics,
        modes=() if verdict == "driven" else other_modes(settled.fit),
        worth=worth,
        too_small=judgement.too_small,
        walk=judgement.walk,
        decided=judgement.decided,
        caution=warned,
        places=judgement.places if named else (),
    )


def _findings(settled: Baseline) -> tuple[CorrectedFault, ...]:
    """List the sensors' faults that every fit corrects but that ought to be mended."""
    faults = unnamed_faults(settled.decays, settled.fit)
    return tuple(f for f in faults if f.p_value < settled.alpha or f.remarked)


def _settled(baseline: Baseline, judgement: Judgement) -> Baseline:
    """Judge the fit with what was found against the noise floor that its own residual shows."""
    if judgement.final is baseline.fit:
        return baseline
    return refit_at_floor(baseline.decays, shared_where_alike(judgement.final))


def _searched(
    first: Baseline,
    whole: tuple[PreparedDecay, ...],
    library: tuple[Effect, ...],
    progress: Callable[[str], None],
) -> tuple[Baseline, Judgement]:
    """Decide the verdict for a model; return it with the baseline that it was judged against.

    That baseline is not `first` where releases differ.
    """
    baseline = where_releases_differ(first)
    curves = _curves(baseline, whole, library)
    fitted = _worth_a_fit(baseline, library, curves)
    tried = singles(baseline, fitted, lambda done, whole: progress(f"fit {done} of {whole}"))
    ranked = with_laws_between(baseline, rank(baseline, tried))
    again = on_second_thought(first, baseline, ranked)
    if again is not baseline:
        baseline, ranked = again, with_laws_between(again, rank(again, singles(again, fitted)))
        curves = _curves(baseline, whole, library)
    progress("judging whether one effect explains it, or several together")
    judgement = judge(baseline, ranked, unnamed_faults(baseline.decays, baseline.fit), library, curves)
    return baseline, judgement


def _worth_a_fit(baseline: Baseline, library: tuple[Effect, ...], curves: Curves) -> tuple[Effect, ...]:
    """List the effects to simulate and fit: all, or, where curves of a long record confirm something, those they mention.

    Every simulation is slow there, and a floor that is a guess is seldom reached.
    """
    if baseline.floor_is_sure or not any(window.segment for window in baseline.fit.windows):
        return library
    found = curves.confirmation
    if found is None or not found.effects:
        return library
    return tuple(effect for effect in library if effect.name in found.mentioned)


def _curves(baseline: Baseline, whole: tuple[PreparedDecay, ...], library: tuple[Effect, ...]) -> Curves:
    """Ask the curves of whole releases for what they confirm beyond a fitted model."""
    forces = Model(baseline.fit.model.forces)
    terms = candidate_terms(baseline.fit.model, library, whole[0].window)
    known = {name: estimate.value for name, estimate in baseline.fit.parameters.items()}
    return Curves(whole, forces, known, terms, scales_of(whole[0], {}))


MORE_DATA = "Record at least ten cycles, from the largest amplitude that is safe."
_AT_REST = "Record the sensor at rest for a second before the release, from a larger amplitude."
_AT_OTHER_LEVELS = "Drive it at half and at one and a half times the level"


def _next_experiment(
    baseline: Baseline, verdict: str, suspects: tuple[Suspect, ...], chosen: NextRelease | None
) -> str:
    if verdict == "not_enough_data":
        return MORE_DATA if too_few_cycles(baseline) else _AT_REST
    if verdict == "driven":
        return "Stop the drive and release the mass."
    if verdict == "sensor_fault" and not suspects[0].rivals:
        return _confirming(suspects[0])
    if chosen is not None:
        together = " Diagnose it together with the releases so far." if verdict == "unknown_effect" else ""
        return chosen.words + together
    if baseline.decays[0].window.force is not None:
        hides = verdict == "nothing_missing"
        why = (
            "an effect that grows faster than the motion may hide"
            if hides
            else "the shape of the missing force must be the same in each"
        )
        return f"{_AT_OTHER_LEVELS}: {why}."
    if verdict == "missing_effect":
        return _confirming(suspects[0])
    return "Release from half and from twice the amplitude, and diagnose all releases together."


def _confirming(suspect: Suspect) -> str:
    return f"{sentence_case(suspect.effect.confirming_test)}."
