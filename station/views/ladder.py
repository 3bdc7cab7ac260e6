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
from station.text.numbers import scale, three_figures, with_unit
from station.views import log, palette, plots
from station.views.figure import figure, legend
from station.views.log import Array
from station.views.plots import literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ROOT = "/ladder"
NAME = "Ladder"
CYCLES = 2.5
NOISE = 2.0
ROOM = 1.15
ERRORS = (
    ("motion_percent", "residual [% of the motion]"),
    ("times_noise", "residual [times the noise]"),
)


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
    close_up = _close_up(fitted)
    reach = _reach(fitted)
    for place in range(len(fitted.fits)):
        here = f"{root}/{place}"
        window = fitted.fits[place].windows[0]
        left = {c: fitted.fits[place].residual(c) for c in window.channels}
        log.picture(stream, f"{here}/motion", _motion(fitted, place, close_up, reach), left)
        errors = {name: [getattr(fitted.steps[place].error, name)] for name, _ in ERRORS}
        log.picture(stream, f"{here}/errors", _errors(fitted, place), errors)
        for curve in _curves(fitted, place):
            drawn, (axis,) = figure(5.4, 3.6)
            plots.measured_curve(axis, curve, plots.SCREEN)
            log.picture(stream, f"{here}/curve", drawn, {})
        log.markdown(stream, f"{here}/summary", summary(fitted, place))


def _curves(fitted: FittedLadder, place: int) -> tuple[MeasuredCurve, ...]:
    """Return the measured curve of a step, the last one where there are several; nothing where there is none."""
    return measured_curves(fitted.fits[place], fitted.steps[place].model.expressions)[-1:]


def _close_up(fitted: FittedLadder) -> slice:
    """Return a few cycles around the place at which the first model is farthest off."""
    fit = fitted.fits[0]
    window = fit.windows[0]
    channel = window.channels[0]
    left = np.where(window.used[channel], np.abs(fit.residual(channel)), 0.0)
    width = int(CYCLES * 2.0 * np.pi / fit.frequency * window.rate)
    smooth = np.convolve(left, np.ones(width), "same")
    middle = int(np.argmax(smooth))
    first = int(np.clip(middle - width // 2, 0, max(len(window) - width, 0)))
    return slice(first, first + width)


def _reach(fitted: FittedLadder) -> float:
    """Measure how far the residual's axis goes on all steps, SI."""
    window = fitted.fits[0].windows[0]
    channel = window.channels[0]
    largest = max(
        float(np.max(np.abs(fit.residual(channel)[window.used[channel]]), initial=0.0)) for fit in fitted.fits
    )
    return ROOM * max(largest, 3.0 * NOISE * window.sigma[channel])


def _motion(fitted: FittedLadder, place: int, close_up: slice, reach: float) -> "Figure":
    fit = fitted.fits[place]
    window = fit.windows[0]
    channel = window.channels[0]
    factor, unit = scale(channel, window.unit)
    fine, fine_unit = scale(channel, window.unit, fine=True)
    time, used = window.clock, window.used[channel]
    measured = np.where(used, window.readings[channel], np.nan)
    model = fit.predicted[0][channel]
    drawn, axes = figure(8.6, 9.4, 3, 1)
    whole, close, left = axes
    _overlay(whole, time, measured * factor, model * factor, 1.0)
    whole.axvspan(time[close_up][0], time[close_up][-1], color=palette.FAINT, alpha=0.35, lw=0)
    whole.set(ylabel=literal(f"{channel} [{unit}]"), xlim=(time[0], time[-1]))
    whole.set_title(f"step {place}: {step_words(fitted.steps[place])}", loc="left", fontsize=13)
    _overlay(close, time[close_up], measured[close_up] * factor, model[close_up] * factor, 4.0)
    close.set(ylabel=literal(f"{channel} [{unit}]"), xlim=(time[close_up][0], time[close_up][-1]))
    close.set_title("where the first model is farthest off", loc="left")
    legend(close, "upper right", ["measured", "model, run freely"])
    noise = NOISE * window.sigma[channel] * fine
    left.axhspan(-noise, noise, color=palette.css(palette.FORCE), alpha=0.3, lw=0)
    left.plot(
        time, np.where(used, fit.residual(channel), np.nan) * fine, color=palette.css(palette.WRONG), lw=1.0
    )
    left.set_yscale("symlog", linthresh=10.0 ** np.ceil(np.log10(noise)))
    left.set(
        xlabel="time since the release [s]", ylabel=literal(f"measured less model [{fine_unit}]"),
        xlim=(time[0], time[-1]), ylim=(-reach * fine, reach * fine),
    )  # fmt: skip
    _number_ends(left, 10.0 ** np.ceil(np.log10(noise)), reach * fine)
    left.set_title("what the model leaves (band: noise, 2 std.; logarithmic beyond)", loc="left")
    return drawn


def _number_ends(axis: "Axes", linear: float, reach: float) -> None:
    """Give an axis that is linear to `linear` and logarithmic beyond numbers that stand within its `reach`."""
    largest = 10.0 ** np.floor(np.log10(reach))
    marks = [mark for mark in (linear, largest) if mark < reach] or [float(f"{0.6 * reach:.1g}")]
    ticks = sorted({0.0, *marks, *(-mark for mark in marks)})
    axis.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_yticks([], minor=True)


def _overlay(axis: "Axes", time: Array, measured: Array, model: Array, dot: float) -> None:
    style = "o" if dot > 2 else "-"
    axis.plot(time, measured, style, color=palette.css(palette.MEASURED), ms=dot, lw=2.2, alpha=0.8)
    axis.plot(time, model, color=palette.css(palette.FORCE), lw=1.3)


def _errors(fitted: FittedLadder, place: int) -> "Figure":
    drawn, axes = figure(5.8, 7.0, len(ERRORS), 1)
    labels = [f"{n}: {step_words(step)}" for n, step in enumerate(fitted.steps)]
    for axis, (name, title) in zip(axes, ERRORS, strict=True):
        values = np.array([getattr(step.error, name) or np.nan for step in fitted.steps])
        floor = getattr(fitted.ladder.floor, name) or np.nan
        shown_values = values[: place + 1]
        colours = [palette.css(palette.REFERENCE)] * place + [palette.css(palette.FORCE)]
        bottom = 0.4 * np.nanmin([*values, floor])
        axis.barh(range(place + 1), shown_values - bottom, left=bottom, color=colours, height=0.6)
        for row, value in enumerate(shown_values):
            axis.annotate(
                f" {three_figures(float(value))}", (value, row), va="center", fontsize=9, color=palette.INK
            )
        axis.axvline(floor, color=palette.css(palette.WRONG), lw=1.5, ls="--")
        axis.set_xscale("log")
        axis.set_xlim(bottom, 6.0 * np.nanmax([*values, floor]))
        axis.set_ylim(max(len(values), 3) - 0.4, -0.6)
        axis.set_yticks(range(place + 1), labels[: place + 1])
        axis.grid(axis="y", visible=False)
        axis.set_title(f"{title} (logarithmic; dashed: noise alone)", loc="left", fontsize=10)
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
        log.shown_picture("The errors fall to the floor", f"{root}/errors"),
        words,
        column_shares=[1.35, 0.9, 0.75],
        name=f"{place}: {step_words(fitted.steps[place])}",
    )
