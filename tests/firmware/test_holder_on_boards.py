"""Both emulated boards hold the mass by magnet and stepper, let go for a recording, and alone when the host is gone."""

import json
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

import pytest
from conftest import or_skip
from fault_bench import station_capture

from bench.emulated import boards, images, motion
from bench.emulated.boards import Board
from daq.errors import BoardError, OperatorError
from daq.link import Link
from daq.port import open_port
from daq.rig import Rig
from firmware_protocol import HolderReason, HolderState

pytestmark = pytest.mark.usefixtures("unrendered")


class Run(Protocol):
    """Start one of the two boards."""

    def __call__(self, befalls: tuple[float, str] | None = None) -> AbstractContextManager[Board]: ...


@pytest.fixture(params=["mega", "launchpad"])
def run(request: pytest.FixtureRequest, tmp_path: Path) -> Run:
    image = request.getfixturevalue(f"{request.param}_holder_image")
    start = getattr(boards, request.param)
    if request.param == "mega":
        or_skip(images.simavr_board, tmp_path / "simavr_board")
    else:
        or_skip(images.need, "qemu-system-arm")
    options = ("--holder", str(motion.REST_S)) if request.param == "mega" else ()

    def started(befalls: tuple[float, str] | None = None) -> AbstractContextManager[Board]:
        return start(tmp_path, image, befalls=befalls, options=options)  # type: ignore[no-any-return]

    return started


@pytest.mark.slow
def test_a_release_by_the_rig_is_recorded_and_identified(run: Run, tmp_path: Path) -> None:
    with run() as board:
        done = station_capture(board.port, tmp_path / "s", "--release", "20mm", "--mass", "21.36")
    assert done.session is not None, done.said
    assert done.session.verdict.grade.value == "OK", done.said
    recording = done.session.recording()
    assert "the rig let go from 20 mm" in recording.notes
    x = recording.samples[0]
    # 20 mm, less where the sensor's middle is: a step of the converter is 3 um, its noise 10 um.
    assert x[: recording.trigger - 8].mean() - x[-64:].mean() == pytest.approx(0.020, abs=0.2e-3)
    found = json.loads((done.session.folder / "results" / "identification.json").read_text("utf-8"))
    for method in ("wavelet", "restoring_force"):
        for value, truth in (
            (found[method]["stiffness_per_mass"], motion.BENCH.stiffness),
            (found[method]["damping"][0], motion.BENCH.mu_0),
            (found[method]["damping"][1], motion.BENCH.mu_1),
        ):
            # Five of its own standard errors, as for a release by hand.
            assert abs(value["value"] - truth) < 5 * value["std"], (method, value, truth)


@pytest.mark.slow
@pytest.mark.parametrize("run", ["launchpad"], indirect=True)  # the Mega is let go of by its contact, below
def test_a_host_that_is_gone_makes_it_let_go_slowly(run: Run) -> None:
    with run() as board, Link(open_port(board.port)) as link:
        link.handshake()
        rig = Rig(link)
        with pytest.raises(OperatorError, match="0 to 25 mm"):
            rig.hold(-0.001)
        link.start()
        rig.hold(0.004)
        link.keep_alive = False
        link.wait(lambda message: rig.report.state is HolderState.LETTING_GO, 4.0)
        assert rig.report.reason is HolderReason.SILENCE
        link.keep_alive = True
        link.wait(lambda message: rig.report.state is HolderState.FREE, 12.0)
        assert rig.report.state is HolderState.FREE
        link.stop()
        x = link.assembly.recording().samples[0]
        # Never faster than 5 mm/s, in a quarter of a second, beside six times the noise of both boards.
        assert abs(x[64:] - x[:-64]).max() < 0.005 / 4 + 60e-6
        with pytest.raises(BoardError):
            rig.release()


@pytest.mark.slow
def test_the_stop_contact_of_the_mega_is_obeyed(mega_holder_image: Path, tmp_path: Path) -> None:
    or_skip(images.simavr_board, tmp_path / "simavr_board")
    options = ("--holder", str(motion.REST_S))
    with (
        boards.mega(tmp_path, mega_holder_image, befalls=(14.0, "open"), options=options) as board,
        Link(open_port(board.port)) as link,
    ):
        link.handshake()
        rig = Rig(link)
        link.start()
        rig.hold(0.004)
        link.wait(lambda message: rig.report.state is not HolderState.HELD, 14.0)
        assert (rig.report.state, rig.report.reason) == (HolderState.LETTING_GO, HolderReason.CONTACT)
