"""Validation: whether a model predicts releases that it was not fitted to, and better than the usual model does."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.fitting.baseline import Baseline, fit_baseline
from identify.fitting.fit import Fit, fit
from identify.fitting.prediction import Prediction, predict, predict_windows
from identify.fitting.segments import prepared_of, segments_of
from identify.formatting import three_figures
from identify.free_decay import FreeDecay
from identify.model.model import Model, base_model
from identify.preprocessing.fit_window import windows_by_release
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.summary import Summarised, Summary

ValidationVerdict = Literal["predicts_better", "no_better", "predicts_worse"]
UsualFrom = Literal["the_same_releases", "the_other_releases", "the_release_itself"]

MOST_RELEASES = 0.66
"""Share of the releases on which a model must predict better (or worse) to be called so."""

ALIKE = 0.02
"""Relative difference of two prediction errors up to which they count as one."""

STRANGE = 50.0
"""Error of the prediction, in % of the motion, from which on neither model seems to be of this bench."""

BASIS: dict[UsualFrom, str] = {
    "the_same_releases": "the usual model was fitted to the same releases as the model",
    "the_other_releases": "the usual model has the medians of its values on each of the other releases",
    "the_release_itself": "the usual model was fitted to this same release, which favours it: that is no prediction",
}


@dataclass(frozen=True)
class Validated:
    """The predictions of release `index` (from 0) by a model and by the usual one."""

    index: int
    model: Prediction
    usual: Prediction

    @property
    def better(self) -> bool:
        """Whether the model predicts clearly better."""
        return self.model.motion_percent < (1.0 - ALIKE) * self.usual.motion_percent

    @property
    def worse(self) -> bool:
        """Whether the model predicts clearly worse."""
        return self.usual.motion_percent < (1.0 - ALIKE) * self.model.motion_percent


@dataclass(frozen=True, eq=False, repr=False)
class Validation(Summarised):
    """The predictions of some releases by a model and by the usual one; `usual_from` says what that was fitted to.

    `held` tells that the linear spring and damper were held too.
    """

    model: Model
    releases: tuple[Validated, ...]
    usual_from: UsualFrom
    held: bool

    @property
    def better(self) -> int:
        """On how many releases the model predicts better."""
        return sum(one.better for one in self.releases)

    @property
    def worse(self) -> int:
        """On how many releases the model predicts worse."""
        return sum(one.worse for one in self.releases)

    @property
    def motion_percent(self) -> float:
        """Median error of the model's prediction, % of the motion; inf where the run diverges."""
        return float(np.median([one.model.motion_percent for one in self.releases]))

    @property
    def usual_motion_percent(self) -> float:
        """Median error of the usual model's prediction, % of the motion."""
        return float(np.median([one.usual.motion_percent for one in self.releases]))

    @property
    def verdict(self) -> ValidationVerdict:
        """Whether the model predicts better on most releases, and in the median."""
        most = MOST_RELEASES * len(self.releases)
        if self.better >= most and self.motion_percent < self.usual_motion_percent:
            return "predicts_better"
        if self.worse >= most and self.motion_percent > self.usual_motion_percent:
            return "predicts_worse"
        return "no_better"

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        count = len(self.releases)
        usual, own = self.usual_motion_percent, self.motion_percent
        median = " (median)" if count > 1 else ""
        bench = (
            " Both miss more than half of the motion: is this another bench?"
            if min(usual, own) > STRANGE
            else ""
        )
        if self.verdict == "no_better":
            how = f"better on {self.better} of {count} releases, worse on {self.worse}"
            return f"Predicts no better than the usual model: {how}; {_from_to(usual, own)}{median}.{bench}"
        word, on = ("better", self.better) if self.verdict == "predicts_better" else ("worse", self.worse)
        where = f" on {on} of {count} releases" if count > 1 else ""
        return f"Predicts {word} than the usual model{where}: {_from_to(usual, own)}{median}.{bench}"

    def brief(self) -> Summary:
        """Summarize the verdict, and both errors on each release."""
        rows = [
            (
                str(one.index),
                three_figures(one.usual.motion_percent),
                three_figures(one.model.motion_percent),
                three_figures(one.usual.chi_square),
                three_figures(one.model.chi_square),
            )
            for one in self.releases
        ]
        head = ("release", "usual, % of motion", "model, % of motion", "usual chi-square", "model chi-square")
        return Summary(
            " + ".join(self.model.names),
            (self.sentence, f"{BASIS[self.usual_from].capitalize()}."),
            head,
            rows,
        )


def validate(
    model: Model,
    values: Mapping[str, float | Estimate],
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
    *,
    fitted_to: Sequence[FreeDecay | PreparedDecay] = (),
    hold: bool = False,
    progress: Callable[[Validated], None] = lambda one: None,
) -> Validation:
    """Predict releases by a model with its values, and by the usual model under the same rule.

    `values` and `hold` are as for `predict`. `fitted_to` are the releases that the model was fitted to: the usual model
    is fitted to them too. Where they are not at hand it takes the medians of what it finds on each of the other
    releases, and with a single release it is fitted to that itself. `progress` is called with each release. Raises
    NotIdentifiable when a release holds too little, ValueError when an effect has no meaning in a release's unit.
    """
    whole = prepared_of(decays)
    if not whole:
        raise NotIdentifiable("There is no release to predict.")
    for unit in {decay.window.unit for decay in whole}:
        wrong = [term.effect.name for term in model.terms if not term.effect.has_meaning_for(unit)]
        if wrong:
            raise ValueError(f"{', '.join(wrong)} has no meaning for a displacement in {unit}")
    each = [fit_baseline(segments_of(decay), base_model()) for decay in whole]
    usual, basis = _usual(each, prepared_of(fitted_to))
    releases = []
    for index, alone in enumerate(each):
        # with the noise that the floor has settled, by which a diagnosis of them counts too
        pairs = zip(alone.decays, alone.fit.windows, strict=True)
        decay = tuple(replace(piece, window=window) for piece, window in pairs)
        one = Validated(
            index,
            predict(model, values, decay, hold=hold),
            predict(base_model(), usual[index], decay, hold=hold),
        )
        progress(one)
        releases.append(one)
    return Validation(model, tuple(releases), basis, hold)


def _usual(
    alone: Sequence[Baseline], fitted_to: tuple[PreparedDecay, ...]
) -> tuple[list[dict[str, float]], UsualFrom]:
    """Choose the usual model's parameters for the prediction of each release, and say where they are from.

    `alone` are its fits to each release by itself.
    """
    if fitted_to:
        together = fit_baseline(segments_of(fitted_to), base_model())
        return [_values(together)] * len(alone), "the_same_releases"
    each = [_values(found) for found in alone]
    if len(each) == 1:
        return each, "the_release_itself"
    medians = []
    for left in range(len(each)):
        others = [values for index, values in enumerate(each) if index != left]
        medians.append({name: float(np.median([v[name] for v in others])) for name in others[0]})
    return medians, "the_other_releases"


def _values(found: Baseline) -> dict[str, float]:
    return {name: estimate.value for name, estimate in found.fit.parameters.items()}


def _from_to(before: float, after: float) -> str:
    """Write two prediction errors, the usual model's last."""
    usual, own = (
        f"{three_figures(e)} % of the motion" if np.isfinite(e) else "a run that diverges"
        for e in (before, after)
    )
    return f"it leaves {own}, the usual model {usual}"


def leave_one_out(found: Fit) -> tuple[Prediction, ...]:
    """Fit to all releases but one and predict the one left out by their physics, for each in turn.

    A long release is left out with all of its segments. Raises NotIdentifiable with a single release.
    """
    groups = windows_by_release(found.windows).values()
    if len(groups) < 2:
        raise NotIdentifiable("Leaving one release out needs at least two.")
    return tuple(_without(found, left) for left in groups)


def _without(found: Fit, left: Sequence[int]) -> Prediction:
    kept = [i for i in range(len(found.windows)) if i not in left]
    windows = tuple(found.windows[i] for i in kept)
    others = fit(found.model, windows, found.of_windows(kept), found.frequency)
    left_windows = tuple(found.windows[i] for i in left)
    physics = {unknown.name: others.point[unknown.name] for unknown in others.unknowns if unknown.window < 0}
    return predict_windows(found.model, physics, left_windows, found.of_windows(left), found.frequency)
