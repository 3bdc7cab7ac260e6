"""The Ladder tab: a tab for each step, whatever the time is; the model closes in, the bars fall to the floor."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

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
from station.text.numbers import scale, with_unit
from station.views import log, palette, plots
from station.views.figure import figure, legend
from station.views.plots import literal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOT = "/ladder"
NAME = "Ladder"
NOISE = 2.0
ROOM = 1.15


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
        window = fitted.fits[place].windows[0]
        left = {c: fitted.fits[place].residual(c) for c in window.channels}
        log.picture(stream, f"{here}/motion", _motion(fitted, place), left)
        error = fitted.steps[place].error
        errors: dict[str, list[float | None]] = {
            "motion_percent": [error.motion_percent],
            "times_noise": [error.times_noise],
        }
        log.picture(stream, f"{here}/errors", _errors(fitted, place), errors)
        for curve in _curves(fitted, place):
            drawn, (axis,) = figure(5.4, 3.6)
            plots.measured_curve(axis, curve, plots.SCREEN)
            log.picture(stream, f"{here}/curve", drawn, {})
        log.markdown(stream, f"{here}/summary", summary(fitted, place))


def _curves(fitted: FittedLadder, place: int) -> tuple[MeasuredCurve, ...]:
    """Return the measured curve of a step, the last one where there are several; nothing where there is none."""
    return measured_curves(fitted.fits[place], fitted.steps[place].model.expressions)[-1:]


def _motion(fitted: FittedLadder, place: int) -> "Figure":
    """Draw the first channel with the model of a step, and the residual on the scale of the first one and of the noise."""
    fit = fitted.fits[place]
    window = fit.windows[0]
    channel = window.channels[0]
    factor, unit = scale(channel, window.unit)
    fine, fine_unit = scale(channel, window.unit, fine=True)
    used = window.used[channel]
    drawn, axes = figure(8.6, 6.4, 3, 1, sharex=True)
    measured = np.where(used, window.readings[channel], np.nan) * factor
    axes[0].plot(window.clock, measured, color=palette.css(palette.MEASURED), lw=2.2)
    axes[0].plot(window.clock, fit.predicted[0][channel] * factor, color=palette.css(palette.FORCE), lw=1.3)
    axes[0].set(
        ylabel=literal(f"{channel} [{unit}]"), title=f"step {place}: {step_words(fitted.steps[place])}"
    )
    legend(axes[0], "upper right", ["measured", "model, run freely"])
    noise = NOISE * window.sigma[channel] * fine
    residual = np.where(used, fit.residual(channel), np.nan) * fine
    first = fitted.fits[0].residual(channel)[used] * fine
    for axis, reach in ((axes[1], float(np.max(np.abs(first), initial=0.0))), (axes[2], 2.0 * noise)):
        axis.axhspan(-noise, noise, color=palette.css(palette.FORCE), alpha=0.3, lw=0)
        axis.plot(window.clock, residual, color=palette.css(palette.WRONG), lw=1.0)
        axis.set(ylabel=literal(f"residual [{fine_unit}]"), ylim=(-ROOM * reach, ROOM * reach))
    axes[1].set_title("residual, on the scale of the first model", loc="left")
    axes[2].set_title("the same, on the scale of the noise (band: 2 std.)", loc="left")
    axes[2].set_xlabel("time since the release [s]")
    return drawn


def _errors(fitted: FittedLadder, place: int) -> "Figure":
    drawn, (axis,) = figure(5.8, 4.2)
    rows = [
        (f"{n}: {step_words(step)}", step.error.chi2 or np.nan)
        for n, step in enumerate(fitted.steps[: place + 1])
    ]
    plots.residuals(axis, rows, fitted.ladder.top.chi2_std, plots.SCREEN)
    return drawn


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
    return rrb.Horizontal(
        log.shown_picture("The model closes in on the measurement", f"{root}/motion"),
        log.shown_picture("The residual falls to the noise", f"{root}/errors"),
        words,
        column_shares=[1.35, 0.9, 0.75],
        name=f"{place}: {step_words(fitted.steps[place])}",
    )
