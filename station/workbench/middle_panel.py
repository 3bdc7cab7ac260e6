"""Middle: what was measured and what the model says, in linked pictures."""

import json

from nicegui import ui

from station.text.numbers import three_figures
from station.workbench import charts, curve_charts, view_models, widgets
from station.workbench.chart_parts import Options
from station.workbench.theme import Theme

NOTICED = 0.15
CURVES = ("curve-frequency", "curve-damping")
HINT = "Move the pointer over a picture, or use the arrow keys in one: the same moment is marked in all."


class MiddlePanel:
    """The pictures of one session; drawn again when the model changes."""

    def __init__(self) -> None:
        self._channel = ""
        self._picture: view_models.Picture | None = None
        self._curves: view_models.DecayCurves | None = None
        self._colours: Theme | None = None
        self._of_ladder: float | None = None
        self._charts: dict[str, ui.echart] = {}

    def build(self) -> None:
        """Make the panel; it is empty until something is shown."""
        with widgets.card("tight"):
            self._numbers = ui.element("div").classes("numbers").props("aria-live=polite")
            self._summary = widgets.label("", "wrap")
            self._cause = widgets.label("", "small faint wrap")
        with widgets.card("tight"):
            with widgets.line():
                self._readout = widgets.label(HINT, "small faint grow readout").props("id=readout")
                self._choice = ui.element("div")
            self._frame = ui.element("div").classes("pictures")

    def show(
        self,
        picture: view_models.Picture,
        curves: view_models.DecayCurves | None,
        colours: Theme,
        of_ladder: float | None,
    ) -> None:
        """Draw a comparison, and the curves of a diagnosis; `of_ladder` is the chi-square that the present rung has."""
        fresh = self._colours is not colours or (self._curves is None) != (curves is None) or not self._charts
        self._curves = curves
        kinds = [trace.channel for trace in picture.traces]
        if self._picture is None or [t.channel for t in self._picture.traces] != kinds:
            self._channel = max(picture.traces, key=_misfit).channel
            self._choose(kinds)
        self._picture, self._colours, self._of_ladder = picture, colours, of_ladder
        self._show_errors(picture)
        options = self._options()
        if fresh:
            self._make(options)
        else:
            for name, chart in self._charts.items():
                chart.options.clear()
                chart.options.update(options[name])
                chart.update()
        self._send_motion(picture)

    def _choose(self, kinds: list[str]) -> None:
        self._choice.clear()
        if len(kinds) > 1:
            with self._choice:
                toggle = ui.toggle(kinds, value=self._channel, on_change=lambda e: self._switch(e.value))
                toggle.props('dense no-caps size=12px padding="1px 9px" unelevated toggle-color=primary')

    def _switch(self, channel: str) -> None:
        self._channel = channel
        if self._picture is not None and self._colours is not None:
            self.show(self._picture, self._curves, self._colours, self._of_ladder)

    def _show_errors(self, picture: view_models.Picture) -> None:
        errors = picture.errors
        self._numbers.clear()
        with self._numbers:
            _number(
                f"{three_figures(errors['chi2'])} ×",
                f"what noise explains (floor 1.00 ± {errors['chi2_std']:.2f})",
            )
            _number(
                f"{three_figures(errors['motion_percent'])} %",
                f"of the motion is left, over {errors['horizon_s']:.1f} s ({errors['cycles']:.0f} cycles)",
            )
            _number(
                f"{three_figures(errors['force_mse_percent'])} %",
                f"of the force is left (MSE; noise alone {three_figures(errors['force_floor_percent'])} %)",
            )
        self._summary.text = picture.summary
        self._cause.text = f"{picture.cause} {_apart(errors['chi2'], self._of_ladder)}".strip()

    def _options(self) -> dict[str, Options]:
        picture, colours = self._picture, self._colours
        assert picture is not None
        assert colours is not None
        trace = next(t for t in picture.traces if t.channel == self._channel)
        at_middle, at_reversal = charts.sections(picture, colours)
        frequency, energy = charts.cycles(picture, colours)
        decay = (
            {}
            if self._curves is None
            else dict(zip(CURVES, curve_charts.decay_curves(self._curves, colours), strict=True))
        )
        return decay | {
            "overlay": charts.overlay(picture, trace, colours),
            "residual": charts.residual(picture, trace, colours),
            "plane": charts.plane(picture, colours),
            "at-middle": at_middle,
            "at-reversal": at_reversal,
            "frequency": frequency,
            "energy": energy,
        }

    def _make(self, options: dict[str, Options]) -> None:
        self._frame.clear()
        self._charts.clear()
        with self._frame:
            for name, (kind, classes, label) in _PLACES.items():
                if name not in options:
                    continue
                chart = ui.echart(options[name]).classes(f"chart {classes}")
                if kind:
                    chart.props["data-kind"] = kind
                chart.props["data-name"] = name
                chart.props["tabindex"] = "0"
                chart.props["role"] = "img"
                chart.props["aria-label"] = label
                self._charts[name] = chart
        ui.run_javascript("bench.link()")

    def _send_motion(self, picture: view_models.Picture) -> None:
        reach = [max((abs(x) for x in values if x is not None), default=1.0) or 1.0
                 for values in (picture.displacement, picture.velocity)]  # fmt: skip
        motion = {
            "t": picture.time,
            "u": picture.displacement,
            "v": picture.velocity,
            "f": picture.force,
            "su": reach[0],
            "sv": reach[1],
            "uu": picture.displacement_unit,
            "vu": picture.velocity_unit,
            "fu": picture.force_unit,
            "hint": HINT,
        }
        ui.run_javascript(f"bench.setMotion({json.dumps(motion)})")


_PLACES = {
    "overlay": ("time", "wide", "Measurement and model over time"),
    "residual": ("time", "wide flat", "Measurement less model over time, with the noise"),
    CURVES[0]: ("", "tall", "Frequency of the decay against amplitude, measured and by the models"),
    CURVES[1]: ("", "tall", "Damping of the decay against amplitude, measured and by the models"),
    "plane": ("plane", "tall", "Phase plane: the missing force over displacement and velocity"),
    "at-middle": ("at-middle", "tall", "The missing force against velocity at zero displacement"),
    "at-reversal": ("at-reversal", "tall", "The missing force against displacement at zero velocity"),
    "frequency": ("time", "tall", "Frequency error cycle by cycle"),
    "energy": ("time", "tall wide", "Energy error cycle by cycle"),
}


def _apart(whole: float, of_ladder: float | None) -> str:
    """Return why comparison and ladder differ, where they do: a long release is refined in pieces."""
    if of_ladder is None or abs(whole - of_ladder) < NOTICED * max(whole, of_ladder):
        return ""
    return (
        f"Here the model runs through the whole record without a new start; the ladder lets it begin anew in pieces "
        f"of a long release, which leaves {three_figures(of_ladder)} times the noise."
    )


def _misfit(trace: view_models.Trace) -> float:
    """Return the mean square of what is left, in units of the noise: the channel that shows it comes first."""
    left = [value for value in trace.left if value is not None]
    return (
        sum(value * value for value in left) / (len(left) * trace.sigma**2)
        if left and trace.sigma > 0
        else 0.0
    )


def _number(value: str, meaning: str) -> None:
    with ui.element("div").classes("number"):
        with ui.element("b"):
            widgets.label(value)
        widgets.label(meaning, "small faint")
