"""What an operator does, by the commands that the README shows, from a file or a board to a result."""

import contextlib
import io
import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from fault_bench import board, without_clock_check

from daq.session import Session, verify
from station import cli, exits

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"
# What the two records were made of, by the program that made them (per unit mass; 21.36 kg; lag in s).
TRUTH = {
    "release_12.csv": (612.3598073615873, 0.1391087551537338, 0.2599697333159229, -0.0010940508563509086),
    "release_24.csv": (612.0013333946838, 0.11453897115374191, 0.29636293457437146, 0.0009845421464880271),
}


@dataclass(frozen=True)
class Done:
    """What a command printed."""

    stdout: str
    stderr: str


@pytest.fixture(autouse=True)
def _headless(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


def station(*arguments: object, cwd: Path, code: int = 0) -> Done:
    """Run a command in this process: the start of another costs seconds."""
    printed, said = io.StringIO(), io.StringIO()
    with contextlib.chdir(cwd), contextlib.redirect_stdout(printed), contextlib.redirect_stderr(said):
        ended = cli.run([str(argument) for argument in arguments])
    assert ended == code, said.getvalue()
    assert "Traceback" not in said.getvalue()
    return Done(printed.getvalue(), said.getvalue())


def program(*arguments: object, cwd: Path, code: int = 0) -> Done:
    """Run a command as a program of its own."""
    command = [sys.executable, "-m", "station", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=120, check=False)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    return Done(done.stdout, done.stderr)


@pytest.mark.parametrize("name", TRUTH)
def test_a_file_of_another_board_is_imported_and_identified(tmp_path, name):
    answer = json.loads(station("import", DATA / name, "--mass", 21.36, "--json", cwd=tmp_path).stdout)
    assert answer["rate_hz"] == pytest.approx(256)
    assert [channel["quantity"] for channel in answer["channels"]] == ["displacement", "acceleration"]
    document = json.loads(station("identify", answer["sessions"][0], "--json", cwd=tmp_path).stdout)
    per_mass, mu_0, mu_1, lag = TRUTH[name]
    # Three times the rms errors that the issue allows, for one record.
    assert document["alignment"]["lag_s"]["value"] == pytest.approx(lag, abs=12e-6)
    for method, stiffness_error in (("wavelet", 1.2e-3), ("restoring_force", 3e-4)):
        found = document[method]
        assert found["stiffness"]["unit"] == "N/m"
        assert found["stiffness"]["value"] == pytest.approx(21.36 * per_mass, rel=stiffness_error)
        assert found["damping"][0]["value"] == pytest.approx(mu_0, rel=0.018)
        assert found["damping"][1]["value"] == pytest.approx(mu_1, rel=0.036)
        assert found["order"] == 1
    kept = json.loads((tmp_path / answer["sessions"][0] / "results" / "identification.json").read_text())
    assert kept == document


def test_a_data_file_can_be_identified_at_once_and_is_not_imported_twice(tmp_path):
    first = json.loads(program("identify", DATA / "release_24.csv", "--json", cwd=tmp_path).stdout)
    again = json.loads(station("identify", DATA / "release_24.csv", "--json", cwd=tmp_path).stdout)
    assert first == again
    assert first["wavelet"]["stiffness"]["unit"] == "1/s^2"
    assert [folder.name for folder in (tmp_path / "sessions").iterdir()] == ["release_24"]


def test_two_releases_in_one_file_become_two_sessions(tmp_path):
    one = (DATA / "release_12.csv").read_text().splitlines()
    two = (DATA / "release_24.csv").read_text().splitlines()
    rows = [line.split(",", 1)[1] for line in one[1:] + two[1:]]
    file = tmp_path / "both.csv"
    file.write_text("\n".join([one[0], *(f"{i / 256:.8f},{row}" for i, row in enumerate(rows))]) + "\n")
    answer = json.loads(station("import", file, "--mass", 21.36, "--json", cwd=tmp_path).stdout)
    assert [Path(folder).name for folder in answer["sessions"]] == ["both_1", "both_2"]
    for folder, name in zip(answer["sessions"], TRUTH, strict=True):
        document = json.loads(station("identify", folder, "--json", cwd=tmp_path).stdout)
        assert document["wavelet"]["damping"][1]["value"] == pytest.approx(TRUTH[name][2], rel=0.036)


def test_the_demo_records_identifies_and_says_where_everything_is(tmp_path):
    answer = json.loads(station("demo", "--speed", 0, "--seed", 3, "--json", cwd=tmp_path).stdout)
    session = Session.open(tmp_path / answer["session"])
    assert verify(session.folder).ok
    assert (tmp_path / answer["viewer_recording"]).stat().st_size > 100_000
    made, found = answer["made_of"], answer["identification"]
    assert found["alignment"]["lag_s"]["value"] == pytest.approx(made["displacement_late_s"], abs=16e-6)
    for method in ("wavelet", "restoring_force"):
        assert found[method]["stiffness"]["value"] == pytest.approx(made["stiffness"], rel=1.2e-3)
        assert found[method]["damping"][0]["value"] == pytest.approx(made["mu_0"], rel=0.018)
        assert found[method]["damping"][1]["value"] == pytest.approx(made["mu_1"], rel=0.036)


@pytest.mark.usefixtures("unrendered")
@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo terminals on Windows")
def test_a_capture_from_a_pseudo_terminal_then_replay_view_verify_and_table(tmp_path):
    options = ("--mass", 21.36, "--duration", 6, "--session", "first", "--json", "--no-viewer")
    with board("pty", "--seed", "4", "--speed", "16") as port, without_clock_check():
        done = station("capture", "--port", port, *options, cwd=tmp_path)
    answer = json.loads(done.stdout)
    assert answer["verdict"]["word"] == "OK"
    assert "ARMED" in done.stderr
    found = answer["identification"]
    assert found["record"]["lost_samples"] == 0
    assert found["wavelet"]["order"] == 1

    replayed = json.loads(station("replay", "first", "--no-viewer", "--json", cwd=tmp_path).stdout)
    assert replayed["identification"] == found
    viewed = json.loads(station("view", "first", "--no-viewer", "--json", cwd=tmp_path).stdout)
    assert (tmp_path / viewed["recording"]).exists()
    assert json.loads(station("verify", "first", "--json", cwd=tmp_path).stdout)["ok"]
    table = json.loads(station("table", "first", "--json", cwd=tmp_path).stdout)
    assert table["table_1"][0]["K (WT)"]["value"] == found["wavelet"]["stiffness"]["value"]
    info = json.loads(station("info", "first", "--json", cwd=tmp_path).stdout)
    assert info["samples"] == found["record"]["samples"]
    assert info["lost_samples"] == 0


def test_no_board_ends_with_3_and_words(tmp_path):
    arguments = ("capture", "--port", "socket://127.0.0.1:9", "--no-viewer")
    done = program(*arguments, cwd=tmp_path, code=exits.NO_BOARD)
    assert len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "sessions").exists()


def test_a_record_of_nothing_ends_with_8_and_one_sentence(tmp_path):
    file = tmp_path / "still.csv"
    file.write_text(
        "time_s,displacement_m\n" + "".join(f"{i / 256},{1e-6 * (i * 7919 % 13)}\n" for i in range(2048))
    )
    done = station("identify", file, "--json", cwd=tmp_path, code=exits.NOT_IDENTIFIABLE)
    assert json.loads(done.stdout)["error"]["exit_code"] == exits.NOT_IDENTIFIABLE


def test_a_flipped_bit_ends_verify_with_7(tmp_path):
    station("import", DATA / "release_24.csv", "--session", "one", cwd=tmp_path)
    raw = tmp_path / "one" / "raw.log"
    content = bytearray(raw.read_bytes())
    content[len(content) // 2] ^= 1
    raw.write_bytes(content)
    done = station("verify", "one", "--json", cwd=tmp_path, code=exits.STORAGE)
    assert not json.loads(done.stdout)["ok"]
    assert "raw.log" in done.stdout


def test_nothing_is_overwritten(tmp_path):
    station("import", DATA / "release_24.csv", "--session", "one", cwd=tmp_path)
    done = station("import", DATA / "release_12.csv", "--session", "one", cwd=tmp_path, code=exits.USAGE)
    assert "one" in done.stderr
    assert verify(tmp_path / "one").ok
