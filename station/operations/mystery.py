"""The mystery: a simulated board hides an effect; compare, diagnose, add, and only then read what it was."""

import re
import secrets
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from daq.session import Session
from identify.effects.library import find_effect
from identify.estimate import Estimate
from identify.formatting import DASH, decimals_for, plain_name
from identify.model.model import base_model
from station.exits import UsageProblem
from station.operations.diagnosing import compare_session, diagnose_sessions
from station.operations.new_session import new_folder
from station.operations.refining import add, open_refinement
from station.operations.session_set import SessionSet
from station.operations.simulated_board import MASS_KG, record_simulated, told_board
from station.operations.viewer_tabs import show_refined
from station.output import asked_for_json, progress, screen
from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder, ladder_document
from station.safe_text import SafeConsole
from station.settings import Settings
from station.story.engineering_values import Weighing
from station.text import comparison_text, diagnosis_text, ladder_text
from station.text.content import Table, Told, Tone, facts
from station.text.layout import answer, show
from station.text.numbers import typeset, with_names, with_unit

SEEDS = 1000
BOARD = "mocks.mystery"
BENCH = Weighing(MASS_KG)


@dataclass(frozen=True, eq=False)
class Solved:
    """The result: the session, the diagnosis, the ladder, and, read last, the truth."""

    seed: int
    session: Session
    diagnosis: DiagnosisDocument
    ladder: KeptLadder
    truth: dict[str, Any]

    @property
    def right(self) -> bool:
        """Whether what was hidden is what was named first, or is not distinguishable from it."""
        return self.diagnosis.named[:1] == [self.truth["hidden"]]


def play(
    settings: Settings,
    seed: int | None,
    speed: float,
    folder: Path | None,
    no_viewer: bool,
) -> None:
    """Record, compare, diagnose, refine, and reveal what was hidden; a seed of None is drawn."""
    console = SafeConsole(quiet=True) if asked_for_json() else screen()
    chosen = secrets.randbelow(SEEDS) if seed is None else seed
    _say(
        console,
        f"THE MYSTERY, number {chosen}",
        "A simulated board hides a force that the usual model does not have, or a faulty sensor. This program does not "
        "know which. It records one release to find out.",
    )
    solved, shown_at = solve(settings, chosen, speed, folder, no_viewer, console)
    _say(console, "4. WHAT WAS HIDDEN: it is read only now")
    answer(_document(solved), revealed(solved), "report", solved.session.folder)
    if not no_viewer:
        show_refined(open_refinement(solved.session, settings), settings, shown_at)


def solve(
    settings: Settings,
    seed: int,
    speed: float,
    folder: Path | None,
    no_viewer: bool,
    console: Console,
) -> tuple[Solved, int | None]:
    """Record the mystery of a seed and solve it, told on a console; return what came out and the live viewer's port."""
    where = folder or new_folder(settings.sessions, f"mystery_{seed}")
    session, shown_at, truth = record_simulated(
        settings, f"mystery {seed}", seed, speed, where, not no_viewer, BOARD
    )
    refinement = open_refinement(session, settings)
    sessions = SessionSet((session,), (refinement.prepared,))
    _say(console, "1. COMPARE: the usual model is fitted, run freely, and laid over the recording")
    compared, _ = compare_session(session, settings, prepared=refinement.prepared)
    worst = [(f"{one.significance:.0f} sigma", typeset(one.text)) for one in compared.comparison.places[:1]]
    show(console, replace(comparison_text.told(compared), brief=facts(worst)))
    _say(console, "2. DIAGNOSE: every effect of the library is added in turn, and fitted")
    _, document = diagnose_sessions(sessions, progress=progress)
    show(console, diagnosis_text.told(document, refinement.weighing))
    ladder = refinement.ladder
    if document.named:
        added = " ".join(f"--add {name}" for name in document.named)
        _say(console, "3. ADD what is named", f"station refine {session.folder.name} {added}")
        for name in document.named:
            ladder = add(replace(refinement, ladder=ladder), name)
        show(
            console,
            replace(ladder_text.told(ladder, refinement.weighing), brief=(ladder_text.steps_table(ladder),)),
        )
    else:
        _say(console, "3. ADD: nothing", "The diagnosis names no effect, so none is added.")
    return Solved(seed, session, document, ladder, truth), shown_at


def what_was_hidden(session: Session) -> dict[str, Any]:
    """Read what the board of a mystery's session hid, which its seed draws; UsageProblem for any other session."""
    seed = re.fullmatch(r"mystery (\d+)", session.info.specimen)
    if seed is None:
        raise UsageProblem(f"{session.folder.name} is no mystery: nothing is known to be hidden in it")
    with told_board(int(seed[1]), 1.0, module=BOARD) as (_, truth):
        pass
    return truth


def hidden_document(truth: dict[str, Any]) -> dict[str, Any]:
    """Write down what was hidden: the effect, its kind, its strengths and its parameters."""
    return {"effect": truth["hidden"]} | {key: truth[key] for key in ("kind", "strengths", "parameters")}


def hidden_words(truth: dict[str, Any]) -> str:
    """Write what was hidden and how strong: "Stribeck friction, 1.14 % of the rms of all forces (dmu = 1.2 N)"."""
    of = "all forces" if truth["kind"] == "physics" else "one channel"
    strength = 100.0 * next(iter(truth["strengths"].values()), 0.0)
    known, own = true_values(truth), f"{truth['hidden']}."
    values = with_names({name.removeprefix(own): known[name] for name in known if name.startswith(own)})
    more = f" ({', '.join(values)})" if values else ""
    return f"{plain_name(truth['hidden'])}, {strength:.2f} % of the rms of {of}{more}"


def revealed(solved: Solved) -> Told:
    """Tell what was hidden, and whether it was found."""
    hidden, left = plain_name(solved.truth["hidden"]), solved.ladder.top.error.words
    tone: Tone = "good" if solved.right else "bad" if solved.diagnosis.named else "unsure"
    if solved.right:
        said = f"FOUND: {hidden} was named, and the model now leaves {left}."
    elif solved.diagnosis.named:
        said = f"NOT FOUND: {plain_name(solved.diagnosis.named[0])} was named instead of {hidden}."
        if solved.truth["hidden"] in solved.diagnosis.suspects[0].confusable_with:
            said += " The diagnosis does say that the two are easily confused."
    else:
        verdict = solved.diagnosis.verdict.replace("_", " ")
        said = f"NOT NAMED: the verdict was '{verdict}', and {hidden} was there."
    return Told(said, tone, (*facts([("hidden", hidden_words(solved.truth))]), _side_by_side(solved)))


def _side_by_side(solved: Solved) -> Table:
    """Put the hidden effect's parameters beside those that were found, each with its unit."""
    found, rows = solved.ladder.top.weighed(BENCH), []
    for name, true in true_values(solved.truth).items():
        estimate, exact = found.get(name), f"{true.value:.5g}"
        if name.endswith(".phase"):  # it counts from another instant there
            continue
        if estimate is not None:
            hidden = f"{true.value:.{decimals_for(estimate.std)}f}" if estimate.std else exact
            rows.append((name, hidden, with_unit(estimate)))
        elif name.startswith(f"{solved.truth['hidden']}."):
            rows.append((name, exact, DASH))
    return Table("", ("", "hidden", "found"), tuple(rows))


def true_values(truth: dict[str, Any]) -> dict[str, Estimate]:
    """Return what the board was made with, by "effect.parameter", with the mass in forces and strengths."""
    base = zip(base_model().terms, ("stiffness_per_mass", "mu_0", "mu_1"), strict=True)
    made = {term.effect.name: {term.strength.parameter: truth[key]} for term, key in base}
    found: dict[str, Estimate] = {}
    for effect, values in (made | truth["parameters"]).items():
        units = {p.name: p.unit for p in find_effect(effect).parameters if "reading" not in p.unit}
        numbers = {name: value for name, value in values.items() if isinstance(value, int | float)}
        bare = {name: Estimate(value, 0.0, units.get(name, "")) for name, value in numbers.items()}
        found |= {f"{effect}.{name}": value for name, value in BENCH.weighed(effect, bare).items()}
    return found


def _document(solved: Solved) -> dict[str, Any]:
    return {
        "seed": solved.seed,
        "session": str(solved.session.folder),
        "diagnosis": solved.diagnosis.plain(),
        "ladder": ladder_document(solved.session, solved.ladder),
        "hidden": hidden_document(solved.truth),
        "right": solved.right,
    }


def _say(console: Console, title: str, text: str = "") -> None:
    """Print a heading, and what is said under it."""
    console.rule(Text(title, style="bold cyan"), align="left")
    if text:
        console.print(Padding(Text(text), (0, 1)))
