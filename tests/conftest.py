"""What all tests share: compiled code is made once, and tests that share what is slow to make stay together."""

import base64
import os
import subprocess
import sys
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import pytest
from hypothesis import settings
from xdist.remote import Producer
from xdist.scheduler import LoadFileScheduling

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: there is a worker a core
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # each of the hundred programs would read all sources again

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")  # the same draws in every run; `python -m bench fuzz` looks for new ones

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
SLOWEST_FIRST = ("workbench", "firmware", "end_to_end", "identify", "docs", "station")

COMPILE = (
    "from station.workbench.tasks import warm_up; warm_up()",
    "from mocks.generate import draw; draw('stribeck_friction+mains_hum', 0.01, 1)",
)
"""What needs most of the compiled functions; numba keeps them beside the sources, for every process after it."""


def pytest_configure(config: pytest.Config) -> None:
    """Compile before the workers start: each would compile the same for itself, as would their programs."""
    if not getattr(config.option, "numprocesses", None) or hasattr(config, "workerinput"):
        return
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    started = [subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, env=environment) for code in COMPILE]
    if sum(process.wait() != 0 for process in started):
        raise pytest.UsageError("the numerical code does not compile; the errors are above")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the folders whose files take longest, so that no worker is left alone with one at the end.

    A test that drives a browser may be begun anew: where the page draws itself anew between two of the driver's steps, a
    click or a letter is lost, as a person's would be, who then repeats it. So may one of a real line: a busy computer reads
    it late, and the recording says so.
    """
    items.sort(key=lambda item: _place(item.path.relative_to(HERE).parts[0]))
    for item in items:
        if item.path.is_relative_to(HERE / "workbench") or item.path.name == "test_fault_table.py":
            item.add_marker(pytest.mark.flaky(reruns=2))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> LoadFileScheduling | None:
    """Give a worker whole files, and one of them all of the workbench: a browser and a server start once, not thrice."""

    class Together(LoadFileScheduling):  # type: ignore[misc]
        def _split_scope(self, nodeid: str) -> str:
            file = str(super()._split_scope(nodeid))
            return file.rpartition("/")[0] if "/workbench/" in file else file

    return Together(config, log) if config.getoption("dist") == "loadfile" else None


def _place(folder: str) -> int:
    return SLOWEST_FIRST.index(folder) if folder in SLOWEST_FIRST else len(SLOWEST_FIRST)


DOT = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a figure be saved as one dot where no test looks at it: rendering takes nine tenths of a capture."""

    def save(figure: object, buffer: BytesIO, **_: object) -> None:
        buffer.write(DOT)

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", save)


FEW = (
    "linear_stiffness", "coulomb_friction", "viscous_damping", "cubic_stiffness", "settling_stiffness",
    "quadratic_damping", "hysteresis", "offset_drift",
)  # fmt: skip


@pytest.fixture(scope="module")
def among_few() -> Iterator[None]:
    """Let the station try few effects where a test is not about which of them is named: all take five times as long."""
    from identify.effects.library import find_effect

    few = tuple(find_effect(name) for name in FEW)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("station.operations.diagnosing.whole_library", lambda file: few)
        yield


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures of a report empty, which take most of its time, where only its words are looked at."""

    def empty(canvas: object, file: BytesIO, **_: object) -> None:
        file.write(b"<svg/>")

    monkeypatch.setattr("matplotlib.backends.backend_svg.FigureCanvasSVG.print_svg", empty)
