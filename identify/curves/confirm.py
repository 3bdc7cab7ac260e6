"""The search for laws that the curves of a decay support: one at a time, the likeliest first.

A law is named where its marginal likelihood beats that of the same model without it, and where it removes enough of the
prediction error to matter. Laws that are nearly as likely are its rivals, and the simplest of them leads. A frequency or
a loss that may move with time as well as with the amplitude names nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from identify.curves.confirmation import Confirmation, ConfirmedEffect
from identify.curves.curve_laws import CurveLaws
from identify.curves.decay_curve import DecayCurve
from identify.curves.held_out import HeldOut, hold_out, parts_of
from identify.curves.isolated_mode import Isolated, isolated
from identify.curves.likelihood import CurveFit, CurveLikelihood, Products
from identify.effects.effect import Effect, Scales
from identify.errors import NotIdentifiable
from identify.evidence import Evidence, complexity, decide
from identify.model.model import Model, Term
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import DRIFTS, LARGE, LEAVES, MOST_ALIKE, RARE

_CHANNELS = {"frequency": "phase", "loss": "envelope"}


@dataclass(frozen=True, eq=False)
class Curves:
    """The curves of some releases, and the laws that they support beyond a model.

    `known` has the model's parameters by unknown's name, `terms` are the candidates.
    """

    decays: tuple[PreparedDecay, ...]
    model: Model
    known: dict[str, float]
    terms: tuple[Term, ...]
    scales: Scales

    @cached_property
    def releases(self) -> tuple[Isolated, ...]:
        """The releases that are long enough for a curve; none where one is driven by a recorded force."""
        try:
            return isolated(self.decays)
        except NotIdentifiable:
            return ()

    @property
    def driven(self) -> DecayCurve | None:
        """The first curve that does not die away; None where all do."""
        return next((one.curve for one in self.releases if one.curve.driven), None)

    @property
    def beats(self) -> bool:
        """Whether the amplitude of some release beats."""
        return any(one.curve.beats for one in self.releases)

    @cached_property
    def confirmation(self) -> Confirmation | None:
        """The laws that the curves support; None where they are too short."""
        if not self.releases:
            return None
        laws = CurveLaws.of(self.releases, self.model, self.known, self.terms, self.scales)
        likelihood = CurveLikelihood(laws)
        return _confirmed(likelihood) if len(parts_of(likelihood)) > 1 else None


def _confirmed(likelihood: CurveLikelihood) -> Confirmation:
    """Find the laws that some curves support."""
    laws = likelihood.laws
    taken = [likelihood.usual()]
    usual = held = hold_out(likelihood, taken[0])
    effects: list[ConfirmedEffect] = []
    asked: list[Evidence] = []
    for _ in _CHANNELS:
        suspects = _averaged([(_worth(likelihood, one), _suspects(likelihood, one)) for one in taken])
        known = {name: laws.laws[one.column].term.effect for name, one in suspects.items()}
        evidence = decide({name: one.nats for name, one in suspects.items()}, known)
        likeliest = evidence.names[:MOST_ALIKE]
        fits = {name: suspects[name].fit for name in likeliest}
        tried = {
            name: hold_out(likelihood, fit if effects else fit.with_last_alone) for name, fit in fits.items()
        }
        borne = [name for name in likeliest if _confirms(laws, suspects[name].column, held, tried[name])]
        named = evidence.verdict == "named"
        if not likeliest or (named and not borne):
            break
        if named:
            first = min(borne, key=lambda name: complexity(known[name]))
            names = (first, *(name for name in evidence.names if name != first))
            evidence = replace(evidence, names=names)
        taken = [fits[name] for name in (evidence.names[:1] if named else likeliest)]
        column, after = suspects[evidence.names[0]].column, tried[evidence.names[0]]
        evidence = replace(evidence, explains=_explained(held, after))
        if any(evidence.explains == one.explains for one in asked):
            break  # a curve of few numbers is not divided between two laws
        if borne:
            asked.append(evidence)
        if named:
            effects.append(_effect(laws, column, held, after, evidence))
            held = after
    return Confirmation(
        tuple(effects),
        usual,
        held,
        usual.one_record,
        tuple(asked),
        tuple(dict.fromkeys(law.name for law in laws.laws[laws.base :])),
        tuple(one.place for one in laws.releases),
    )


@dataclass(frozen=True, eq=False)
class _Suspect:
    """A law with its evidence (nats) against the model without it, the likeliest of its columns, and its fit."""

    nats: float
    column: int
    fit: CurveFit


def _averaged(several: Sequence[tuple[float, dict[str, _Suspect]]]) -> dict[str, _Suspect]:
    """Weigh suspects beside each of some hypotheses, and average over these by their evidence (nats)."""
    of_all = float(np.logaddexp.reduce([nats for nats, _ in several]))
    averaged = {}
    for name in dict.fromkeys(name for _, suspects in several for name in suspects):
        # beside a law that is the same there is nothing to gain
        nats = [base + (suspects[name].nats if name in suspects else -np.inf) for base, suspects in several]
        likeliest = several[int(np.argmax(nats))][1][name]
        averaged[name] = replace(likeliest, nats=float(np.logaddexp.reduce(nats)) - of_all)
    return averaged


def _suspects(likelihood: CurveLikelihood, before: CurveFit) -> dict[str, _Suspect]:
    """Weigh each law that a model lacks, its evidence averaged over its inner parameters; by name."""
    laws = likelihood.laws.laws
    known = {laws[c].name for c in likelihood.columns(before.added)}
    products = likelihood.products(likelihood.observed, range(len(laws)))
    tried: dict[str, list[tuple[int, CurveFit]]] = {}
    for column in range(len(likelihood.base), len(laws)):
        if laws[column].name not in known and likelihood.laws.natural[column] > 0.0:
            found = likelihood.with_law(products, before, column)
            tried.setdefault(laws[column].name, []).append((column, found))
    suspects = {}
    for name, several in tried.items():
        column, best = max(several, key=lambda one: one[1].nats)
        if best.possible:
            average = np.log(np.mean(np.exp([one.nats - best.nats for _, one in several])))
            effect = laws[column].term.effect
            nats = best.nats + float(average) - before.nats - _price(effect)
            suspects[name] = _Suspect(nats, column, best)
    suspects |= {
        name: _corrected(likelihood, before, one) for name, one in suspects.items() if one.nats > 0.0
    }
    if before.added.laws:
        return suspects
    names = sorted(suspects, key=lambda name: -suspects[name].nats)
    most = suspects[names[0]].nats if names else 0.0
    alone = dict(suspects)
    for place, name in enumerate(names):
        weaker = [alone[other] for other in names[place + 1 :]]
        if most <= 0.0 or alone[name].nats + max(weaker[0].nats if weaker else 0.0, 0.0) < most:
            break
        suspects[name] = _or_with_another(likelihood, products, alone[name], weaker)
    return suspects


def _price(effect: Effect) -> float:
    """Return the prior evidence against an effect, nats."""
    return RARE * complexity(effect) + (DRIFTS if effect.of_time else 0.0)


def _worth(likelihood: CurveLikelihood, one: CurveFit) -> float:
    """Return the evidence for a fit, less the price of the laws that it adds, nats."""
    return one.nats - sum(_price(likelihood.laws.laws[c].term.effect) for c in one.added.laws)


def _or_with_another(
    likelihood: CurveLikelihood, products: Products, one: _Suspect, weaker: Sequence[_Suspect]
) -> _Suspect:
    """Weigh a suspect alone and together with each one that is less likely alone."""
    laws = likelihood.laws.laws
    pairs = [
        likelihood.with_law(products, one.fit, other.column).nats
        - one.fit.nats
        - _price(laws[other.column].term.effect)
        - np.log(1.0 + len(weaker))
        for other in weaker
    ]
    return replace(one, nats=one.nats + float(np.logaddexp.reduce([0.0, *pairs])))


def _corrected(likelihood: CurveLikelihood, before: CurveFit, one: _Suspect) -> _Suspect:
    """Weigh a suspect again, with the curves corrected for what windows and averaging do to its own motion."""
    found = likelihood.with_own_corrections(before, one.fit)
    if not found.possible:
        return one
    return replace(one, nats=one.nats + found.nats - one.fit.nats, fit=found)


def _confirms(laws: CurveLaws, column: int, before: HeldOut, after: HeldOut) -> bool:
    """Check that the held-out parts confirm a law: it removes a large enough prediction error, and most of one kind."""
    removed = before.typical("motion") - after.typical("motion")
    left = min(after.typical(kind) / before.typical(kind) for kind in _CHANNELS.values())
    plausible = laws.plausible(column, float(after.strengths[-1]))
    return plausible and removed >= LARGE and left <= LEAVES


def _explained(before: HeldOut, after: HeldOut) -> str:
    """Decide whether a law explains the "frequency" or the "loss"."""
    return max(_CHANNELS, key=lambda what: before.typical(_CHANNELS[what]) - after.typical(_CHANNELS[what]))


def _effect(
    laws: CurveLaws, column: int, before: HeldOut, after: HeldOut, evidence: Evidence
) -> ConfirmedEffect:
    law = laws.laws[column]
    channel = _CHANNELS[evidence.explains]
    return ConfirmedEffect(
        term=law.term,
        strength=float(after.strengths[-1]),
        explains=evidence.explains,
        before=before.typical(channel),
        after=after.typical(channel),
        better=after.better(before, channel),
        parts=len(after.predicted),
        evidence=evidence,
        rivals=evidence.names[1:],
    )
