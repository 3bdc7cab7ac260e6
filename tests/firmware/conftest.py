"""The images, built once a worker; tests whose tools are not on this machine are skipped and say so."""

import sys
from pathlib import Path

import pytest

from bench.emulated import images

sys.path.insert(
    0, str(Path(__file__).parents[1] / "end_to_end")
)  # fault_bench: the promises of docs/faults.md


@pytest.fixture(scope="session")
def mega_image(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return or_skip(images.mega, tmp_path_factory.mktemp("mega") / "mega.elf")


@pytest.fixture(scope="session")
def launchpad_image(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return or_skip(images.launchpad, tmp_path_factory.mktemp("launchpad") / "launchpad.elf", *images.EMULATED)


@pytest.fixture(scope="session")
def mega_holder_image(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return or_skip(
        images.mega, tmp_path_factory.mktemp("mega") / "holder.elf", "atmega2560", "-DBOARD_HOLDER=1"
    )


@pytest.fixture(scope="session")
def launchpad_holder_image(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("launchpad") / "holder.elf"
    return or_skip(images.launchpad, out, *images.EMULATED, "-DBOARD_HOLDER=1")


def or_skip(build: object, *arguments: object) -> Path:
    try:
        return build(*arguments)  # type: ignore[operator, no-any-return]
    except images.ToolMissing as missing:
        pytest.skip(str(missing))


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a figure be saved as one byte: no test here looks at it."""
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda figure, buffer, **_: buffer.write(b"."))
