"""A guided test in a terminal: what to release and why, and odds that move from release to release."""

from rich.bar import Bar
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from daq.capture import CaptureObserver
from identify.diagnosis.guidance import MOST, Guidance, State
from identify.formatting import odds_words
from station.results.diagnosis_document import DiagnosisDocument, HypothesisDocument
from station.results.guide_document import GuideDocument, TurnDocument
from station.text.capture_progress import Watch
from station.text.content import Told, Tone, facts
from station.text.diagnosis_text import headline, tone_of
from station.text.layout import STYLES, labelled, show
from station.text.numbers import typeset

BAR, NAME, SHOWN = 24, 27, 5
ENDINGS: dict[State, tuple[str, Tone]] = {
    "confirmed": ("CONFIRMED", "good"),
    "nothing": ("NOTHING IS MISSING", "good"),
    "no_name": ("SOMETHING IS MISSING, AND NO EFFECT CAN BE NAMED", "bad"),
    "alike": ("NOT DISTINGUISHABLE ON THIS RIG", "unsure"),
    "given_up": ("NOT DECIDED", "unsure"),
    "go_on": ("STOPPED", "unsure"),
}


class GuideScreen:
    """Prints a guided test as it goes on."""

    def __init__(self, console: Console, *, alone: bool) -> None:
        self._console, self._alone = console, alone
        self._odds: dict[str, float] = {}
        self.observer: CaptureObserver = Watch()

    def asks(self, number: int, told: Guidance) -> None:
        """Print what to release, and why."""
        assert told.experiment is not None
        self._console.print()
        self._console.rule(
            Text(f"release {number} of at most {MOST}: {to_do(told)}", style="bold cyan"), align="left"
        )
        self._console.print(labelled("why", told.words))
        if not self._alone:
            self._console.print(labelled("do", "hold it still until it is armed, then let go"))

    def provisional(self, answer: str) -> None:
        """Print a first answer while the decay is still running."""
        self._console.print(labelled("so far", f"{answer} (the decay is still running)"))

    def judged(self, turn: TurnDocument, document: DiagnosisDocument | None) -> None:
        """Print the verdict and the odds."""
        self._console.print()
        if document is None:
            self._console.print(labelled("no result", turn.problem))
            return
        late = "" if turn.judged_s is None else f"   {turn.judged_s:.1f} s after the end"
        line = Text(f" {headline(document)}", style=STYLES[tone_of(document)])
        self._console.print(line.append(late, style="dim"))
        self._console.print(Padding(odds_chart(turn.hypotheses, self._odds), (0, 0, 0, 1)))
        if told := gave(turn):
            self._console.print(labelled("it gave", told))
        self._odds = odds_of(turn.hypotheses)


def gave(turn: TurnDocument) -> str:
    """Say what evidence a release gave between two hypotheses, beside what was expected of it; "" where none was."""
    if turn.gave_nats is None or turn.expected_nats is None:
        return ""
    one, other = turn.between if turn.gave_nats >= 0.0 else reversed(turn.between)
    expected = f"{odds_words(turn.expected_nats)} for {turn.between[0]} expected"
    return f"odds of {odds_words(abs(turn.gave_nats))} for {one} against {other}; {expected}"


def to_do(told: Guidance) -> str:
    """Say what to do with the mass, in a clause."""
    assert told.experiment is not None
    one = told.experiment
    size = f"{1e3 * one.amplitude:.3g} mm".replace("-", "−")
    more = f", and record {one.longer:g} times as long" if one.longer > 1.0 else ""
    return f"push it so that it swings to {size}{more}" if one.push else f"from {size}{more}"


def odds_chart(hypotheses: list[HypothesisDocument], before: dict[str, float]) -> Table:
    """Draw the odds of each hypothesis as a bar, with what they were before this release."""
    table = Table.grid(padding=(0, 1, 0, 0))
    table.add_column(width=NAME, no_wrap=True, overflow="ellipsis")
    table.add_column(width=BAR, no_wrap=True)
    for column in ("right", "left"):
        table.add_column(justify=column, no_wrap=True)
    for one in hypotheses[:SHOWN]:
        odds = one.odds or 0.0
        was = Text(odds_before(one, before), style="dim")
        table.add_row(Text(one.title), Bar(1.0, 0.0, odds, width=BAR, color="cyan"), percent(odds), was)
    return table


def odds_of(hypotheses: list[HypothesisDocument]) -> dict[str, float]:
    """Return the odds of hypotheses by their titles."""
    return {one.title: one.odds or 0.0 for one in hypotheses}


def odds_before(one: HypothesisDocument, before: dict[str, float]) -> str:
    """Write the odds of a hypothesis before the last release, in brackets; "" after the first one."""
    return f"(was {percent(before[one.title])})" if one.title in before else "(new)" if before else ""


def percent(share: float) -> str:
    """Write odds in %."""
    return "under 1 %" if share < 0.01 else "over 99 %" if share > 0.99 else f"{100 * share:.0f} %"


def show_guide(console: Console, document: GuideDocument) -> None:
    """Print how a guided test ended, and where all of it is."""
    title, tone = ENDINGS[document.state]
    places = (("report", document.report), ("campaign", document.campaign), ("all of it", document.folder))
    console.print()
    kept = facts((("because", typeset(document.words)), *((label, place or "") for label, place in places)))
    show(console, Told(title, tone, (), kept), full=True)
    console.print()
