"""The Ladder tab: a tab for each step, whatever the time is; the model closes in, the bars fall to the floor."""

from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.fitting.fit import Fit
from identify.formatting import plain_name
from station.results.ladder import KeptLadder, KeptStep
from station.story.measured_curves import MeasuredCurve, measured_curves
from station.text import ladder_text
from station.text.content import Equation, Paragraph, facts, markdown
from station.text.ladder_text import step_words
from station.text.numbers import with_unit
from station.views import log, palette
from station.views.comparison_figures import front
from station.views.diagnosis_figures import measured_curve, residuals

ROOT = "/ladder"
NAME = "Ladder"


@dataclass(frozen=True, eq=False)
class FittedLadder:
    """What the tab shows: the ladder of the session `name`, and the fit of each step up to the present one."""

    name: str
    ladder: KeptLadder
    fits: tuple[Fit, ...]

    @property
    def steps(self) -> tuple[KeptStep, ...]:
        """The steps up to the present one."""
        return self.ladder.steps[: len(self.fits)]


def write(stream: rr.RecordingStream, fitted: FittedLadder, root: str = ROOT) -> None:
    """Log each step under a path of its own; `root` is another one each time the ladder has changed."""
    for place in range(len(fitted.fits)):
        here = f"{root}/{place}"
        names = [f"{n}: {step_words(step)}" for n, step in enumerate(fitted.steps[: place + 1])]
        each = list(zip(names, fitted.fits, strict=False))
        first_and_this = [each[0], *each[1:][-1:]]
        log.picture(stream, f"{here}/motion", front(first_and_this, palette.SCREEN))
        rows = [(name, step.error.chi2 or np.nan) for name, step in zip(names, fitted.steps, strict=False)]
        log.picture(stream, f"{here}/errors", residuals(rows, fitted.ladder.top.chi2_std, palette.SCREEN))
        for curve in _curves(fitted, place):
            log.picture(stream, f"{here}/curve", measured_curve(curve, palette.SCREEN))
        log.markdown(stream, f"{here}/summary", summary(fitted, place))


def _curves(fitted: FittedLadder, place: int) -> tuple[MeasuredCurve, ...]:
    """Return the measured curve of a step, the last one where there are several; nothing where there is none."""
    return measured_curves(fitted.fits[place], fitted.steps[place].model.expressions)[-1:]


def summary(fitted: FittedLadder, place: int) -> str:
    """Tell one step as markdown: the ladder up to it, what changed, and the model with its values."""
    step = fitted.steps[place]
    why = fitted.ladder.stopped_because if place == len(fitted.steps) - 1 else ""
    up_to = fitted.ladder.with_(steps=fitted.steps[: place + 1], present=place, stopped_because=why)
    words = ladder_text.told(up_to)
    values = facts((name, with_unit(value)) for name, value in step.parameters.items())
    model = (
        Paragraph(" + ".join(plain_name(name) for name in step.effects)),
        Equation((step.model.equation,)),
    )
    told = markdown((*words.brief, *words.more, *model, *values))
    return f"# {fitted.name}, step {place}\n\n{words.headline}\n\n{told}"


def tab(fitted: FittedLadder, root: str = ROOT) -> rrb.Container:
    """Return the layout of the tab: the present step is in front."""
    steps = [_step(fitted, place, f"{root}/{place}") for place in range(len(fitted.fits))]
    return rrb.Tabs(*steps, active_tab=len(steps) - 1, name=NAME)


def _step(fitted: FittedLadder, place: int, root: str) -> rrb.Container:
    words: rrb.View | rrb.Container = log.document("This step", f"{root}/summary")
    if _curves(fitted, place):
        curve = log.shown_picture("The measured curve", f"{root}/curve")
        words = rrb.Vertical(words, curve, row_shares=[1.6, 1.0])
    pictures = rrb.Vertical(
        log.shown_picture("The model closes in on the measurement", f"{root}/motion"),
        log.shown_picture("The residual falls to the noise", f"{root}/errors"),
        row_shares=[2.0, 1.0],
    )
    name = f"{place}: {step_words(fitted.steps[place])}"
    return rrb.Horizontal(pictures, words, column_shares=[2.0, 1.0], name=name)
