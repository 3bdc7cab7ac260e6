"""The Ladder tab: a tab for each step, whatever the time is; the model closes in on the measurement."""

from dataclasses import dataclass

import rerun as rr
import rerun.blueprint as rrb

from identify.fitting.fit import Fit
from identify.formatting import plain_name
from station.results.ladder import KeptLadder
from station.story.measured_curves import measured_curves
from station.text import ladder_text
from station.text.content import Equation, Paragraph, facts, markdown
from station.text.ladder_text import step_words
from station.text.numbers import with_unit
from station.views import log
from station.views.comparison_figures import front
from station.views.diagnosis_figures import measured_curve
from station.views.palette import Look


@dataclass(frozen=True, eq=False)
class FittedLadder:
    """The ladder of the session `name`, and the fit of each step up to the present one.

    `root` is the path under which it is drawn: another one each time the ladder has changed.
    """

    name: str
    ladder: KeptLadder
    fits: tuple[Fit, ...]
    root: str = "/ladder"

    def tab(self, stream: rr.RecordingStream, look: Look) -> rrb.Container:
        """Show each step under a path of its own, the present one in front."""
        steps = [self._step(stream, look, place) for place in range(len(self.fits))]
        return rrb.Tabs(*steps, active_tab=len(steps) - 1, name="Ladder")

    def _step(self, stream: rr.RecordingStream, look: Look, place: int) -> rrb.Container:
        here, step = f"{self.root}/{place}", self.ladder.steps[place]
        names = [f"{n}: {step_words(one)}" for n, one in enumerate(self.ladder.steps)]
        shown = [(names[n], self.fits[n]) for n in sorted({0, place})]
        title = "The model closes in on the measurement"
        motion = log.picture(stream, title, f"{here}/motion", front(shown, look))
        words = [log.markdown(stream, "This step", f"{here}/summary", self._summary(place))]
        for curve in measured_curves(self.fits[place], step.model.expressions)[-1:]:
            drawn = measured_curve(curve, look)
            words.append(log.picture(stream, "The measured curve", f"{here}/curve", drawn))
        column = rrb.Vertical(*words, row_shares=[1.6, 1.0][: len(words)])
        return rrb.Horizontal(motion, column, column_shares=[2.0, 1.0], name=names[place])

    def _summary(self, place: int) -> str:
        """Tell one step as markdown: the ladder up to it, what changed, and the model with its values."""
        step = self.ladder.steps[place]
        why = self.ladder.stopped_because if place == len(self.fits) - 1 else ""
        up_to = self.ladder.with_(steps=self.ladder.steps[: place + 1], present=place, stopped_because=why)
        words = ladder_text.told(up_to)
        model = Paragraph(" + ".join(plain_name(name) for name in step.effects))
        values = facts((name, with_unit(value)) for name, value in step.parameters.items())
        parts = (*words.brief, *words.more, model, Equation((step.model.equation,)), *values)
        return f"# {self.name}, step {place}\n\n{words.headline}\n\n{markdown(parts)}"
