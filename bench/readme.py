"""`python -m bench.readme`: the README's figures of mystery 7, recorded, solved and written between its two markers."""

import io
import sys
import tempfile
from pathlib import Path

from rich.console import Console

from bench.workbench_server import ROOT
from identify.formatting import plain_name, three_figures
from identify.residual import times
from station.operations.mystery import Solved, solve
from station.settings import Settings
from station.text.ladder_text import steps_table
from station.text.layout import show_parts

PAGE = ROOT / "README.md"
BEGIN, END = "<!-- mystery:begin -->\n", "<!-- mystery:end -->\n"
SEED = 7
WIDTH = 80


def mystery(folder: Path) -> Solved:
    """Record and solve the README's mystery in a folder."""
    return solve(Settings(sessions=folder), SEED, 0.0, None, True, Console(quiet=True))[0]


def block(solved: Solved) -> str:
    """Return what stands between the markers: the figures in words, the commands, and the ladder."""
    named, (first, *_, last) = solved.diagnosis.named[0], solved.ladder.steps
    words = (
        f"The usual model (stiffness, dry and viscous friction) leaves {three_figures(first.error.motion_percent)} % of the motion,\n"
        f"which is {times(first.error.chi2)} times the noise of the sensors (`station compare mystery_{SEED} --model usual`).\n"
        f"`station diagnose mystery_{SEED} --model usual` tries every effect; only {plain_name(named)} reaches the noise.\n"
        f"`station refine mystery_{SEED} --add {named}` adds it and leaves {times(last.error.chi2)} times the noise:\n"
    )
    return f"{words}\n```\n{_ladder(solved)}\n```\n"


def _ladder(solved: Solved) -> str:
    """Return the table of the ladder as the terminal shows it."""
    written = io.StringIO()
    console = Console(file=written, width=WIDTH, highlight=False, no_color=True)
    show_parts(console, [steps_table(solved.ladder)])
    return "\n".join(line.rstrip() for line in written.getvalue().splitlines())


def inside(page: str) -> str:
    """Return what stands between the markers of a page."""
    return page.split(BEGIN)[1].split(END)[0]


def main() -> int:
    """Write the block into the README."""
    page = PAGE.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        made = block(mystery(Path(folder)))
    PAGE.write_text(page.replace(BEGIN + inside(page) + END, BEGIN + made + END), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
