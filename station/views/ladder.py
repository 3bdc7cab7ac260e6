"""The Ladder tab: a tab for each step, whatever the time is; the model closes in on the measurement."""

import rerun as rr
import rerun.blueprint as rrb

from identify.fitting.fit import Fit
from identify.formatting import plain_name
from station.results.ladder import KeptLadder
from station.story.engineering_values import Weighing
from station.story.measured_curves import measured_curves
from station.text import ladder_text
from station.text.content import Equation, Paragraph, facts, markdown
from station.text.ladder_text import step_words
from station.text.numbers import with_unit
from station.views import log
from station.views.comparison_figures import front
from station.views.diagnosis_figures import measured_curve
from station.views.palette import Look


def tab(
    stream: rr.RecordingStream,
    look: Look,
    name: str,
    ladder: KeptLadder,
    fits: tuple[Fit, ...],
    weighing: Weighing,
    root: str,
) -> rrb.Container:
    """Show each step of the ladder of the session `name` under a path of its own, the present one in front.

    `fits` are those of the steps up to the present one; `root` is another path each time the ladder has changed.
    """
    names = [f"{n}: {step_words(one)}" for n, one in enumerate(ladder.steps)]

    def shown(place: int) -> rrb.Container:
        here, expressions = f"{root}/{place}", ladder.steps[place].model.expressions
        drawn = front([(names[n], fits[n]) for n in sorted({0, place})], look)
        motion = log.picture(stream, "The model closes in on the measurement", f"{here}/motion", drawn)
        up_to = ladder.with_(steps=ladder.steps[: place + 1], present=place)
        up_to = up_to if place == len(fits) - 1 else up_to.with_(stopped_because="")
        words = [
            log.markdown(stream, "This step", f"{here}/summary", _summary(name, up_to, fits[place], weighing))
        ]
        for curve in measured_curves(fits[place], expressions)[-1:]:
            drawn = measured_curve(curve, weighing, look)
            words.append(log.picture(stream, "The measured curve", f"{here}/curve", drawn))
        column = rrb.Vertical(*words, row_shares=[1.6, 1.0][: len(words)])
        return rrb.Horizontal(motion, column, column_shares=[2.0, 1.0], name=names[place])

    return rrb.Tabs(*map(shown, range(len(fits))), active_tab=len(fits) - 1, name="Ladder")


def _summary(name: str, ladder: KeptLadder, fit: Fit, weighing: Weighing) -> str:
    """Tell a step as markdown: the ladder up to it, what changed, and the model with its values."""
    step, words = ladder.top, ladder_text.told(ladder, weighing)
    model = Paragraph(" + ".join(plain_name(effect) for effect in step.effects), weighing.words)
    equation = Equation((f"{' + '.join(weighing.terms(term.effect for term in fit.model.terms))} = 0",))
    values = facts((parameter, with_unit(value)) for parameter, value in step.weighed(weighing).items())
    parts = (*words.brief, *words.more, model, equation, *values)
    return f"# {name}, step {ladder.present}\n\n{words.headline}\n\n{markdown(parts)}"
