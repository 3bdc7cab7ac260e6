"""Details: curves of frequency and damping, cuts through the missing force, errors cycle by cycle."""

from nicegui import ui

from station.story.residual import floor_words, times
from station.text.numbers import three_figures
from station.workbench import charts, curve_charts, view_models, widgets
from station.workbench.chart_parts import Options
from station.workbench.session_state import SessionState
from station.workbench.theme import Theme

NOTICED = 0.15
CURVES = ("curve-frequency", "curve-damping")
PLACES = {
    CURVES[0]: "Frequency of the decay against amplitude, measured and by the models",
    CURVES[1]: "Damping of the decay against amplitude, measured and by the models",
    "at-middle": "The missing force against velocity at zero displacement",
    "at-reversal": "The missing force against displacement at zero velocity",
    "frequency": "Frequency error cycle by cycle",
    "energy": "Energy error cycle by cycle",
}


class DetailsPanel:
    """The further pictures of one session's present model; nothing is drawn while the tab is not looked at."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._drawn: object = None
        self._names: tuple[str, ...] = ()
        self._colours: Theme | None = None
        self._charts: dict[str, ui.echart] = {}

    def build(self) -> None:
        """Make the panel; it is empty until something is shown."""
        self._wait = widgets.label("", "faint")
        with widgets.card("tight") as self._top:
            self._numbers = ui.element("div").classes("numbers")
            self._summary = widgets.label("", "wrap")
            self._cause = widgets.label("", "small faint wrap")
        self._frame = ui.element("div").classes("pictures")

    def show(self, colours: Theme) -> None:
        """Draw the comparison and the curves of the session as it stands, unless they are drawn already."""
        view, found = self._session.view, self._session.details
        self._wait.text = self._session.no_details or "Comparing the model with the measurement …"
        if (found, colours) == self._drawn:
            return
        self._drawn = (found, colours)
        for part in (self._top, self._frame):
            part.set_visibility(found is not None)
        self._wait.set_visibility(found is None)
        if found is None or view is None:
            return
        self._show_errors(found.picture, view.ladder.top.error.chi2)
        options = _options(found, colours)
        if tuple(options) != self._names or colours is not self._colours:
            self._names, self._colours = tuple(options), colours
            self._make(options)
            return
        for name, chart in self._charts.items():
            chart.options.clear()
            chart.options.update(options[name])
            chart.update()

    def _show_errors(self, picture: view_models.Picture, of_ladder: float | None) -> None:
        errors = picture.errors
        self._numbers.clear()
        with self._numbers:
            _number(
                f"{three_figures(errors['motion_percent'])} %",
                f"of the motion is the residual of {picture.words}, over {errors['horizon_s']:.1f} s "
                f"({errors['cycles']:.0f} cycles)",
            )
            _number(
                f"{times(errors['chi2'])} ×",
                f"the noise is its rms (noise alone: {floor_words(errors['chi2_std'])})",
            )
        self._summary.text = picture.summary
        self._cause.text = f"{picture.cause} {_apart(errors['chi2'], of_ladder)}".strip()

    def _make(self, options: dict[str, Options]) -> None:
        self._frame.clear()
        self._charts.clear()
        with self._frame:
            for name, option in options.items():
                chart = ui.echart(option).classes("chart tall")
                chart.props["data-name"] = name
                chart.props["tabindex"] = "0"
                chart.props["role"] = "img"
                chart.props["aria-label"] = PLACES[name]
                self._charts[name] = chart


def _options(found: view_models.Details, colours: Theme) -> dict[str, Options]:
    at_middle, at_reversal = charts.sections(found.picture, colours)
    frequency, energy = charts.cycles(found.picture, colours)
    drawn = curve_charts.decay_curves(found.curves, colours) if found.curves is not None else ()
    return dict(zip(CURVES, drawn, strict=False)) | {
        "at-middle": at_middle,
        "at-reversal": at_reversal,
        "frequency": frequency,
        "energy": energy,
    }


def _apart(whole: float, of_ladder: float | None) -> str:
    """Say why comparison and ladder differ, where they do: a long release is refined in pieces."""
    if of_ladder is None or abs(whole - of_ladder) < NOTICED * max(whole, of_ladder):
        return ""
    return (
        f"Here the model runs through the whole record without a new start; the ladder lets it begin anew in pieces "
        f"of a long release, which leaves {times(of_ladder)} times the noise."
    )


def _number(value: str, meaning: str) -> None:
    with ui.element("div").classes("number"):
        with ui.element("b"):
            widgets.label(value)
        widgets.label(meaning, "small faint")
