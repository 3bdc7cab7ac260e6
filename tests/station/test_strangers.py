"""A session from a stranger can be opened: its strings do not command the terminal, its names lead nowhere."""

import contextlib
import io
import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from daq.importing import read_file
from daq.session import Session
from station import cli
from station.output import progress
from station.safe_text import harmless

EVIL = "\x1b]0;owned\x07\x1b[2Jname\x9b31m\u202egnp.exe"
SAMPLE = Path(__file__).parents[1] / "data" / "release_24.csv"
DANGEROUS = ("\x1b", "\x07", "\x9b", "\x08")


def station(*arguments: str) -> tuple[int, str]:
    """Return the exit code and all that a terminal would get."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
        code = cli.run(list(arguments))
    return code, told.getvalue()


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sound") / "one"
    assert station("import", str(SAMPLE), "--session", str(folder))[0] == 0
    return folder


@pytest.fixture
def stranger(sound: Path, tmp_path: Path) -> Path:
    """A copy whose session.json says what a stranger wrote."""
    return Path(shutil.copytree(sound, tmp_path / "sessions" / "one"))


def rewrite(session: Path, **changes: object) -> None:
    file = session / "session.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | changes))


@pytest.mark.parametrize("command", ["info", "verify", "identify", "list"])
@pytest.mark.parametrize("as_json", [False, True])
def test_strings_of_a_session_do_not_command_the_terminal(
    stranger: Path, command: str, as_json: bool
) -> None:
    rewrite(stranger, name=EVIL, specimen=EVIL, operator=EVIL, source=EVIL, remarks=EVIL)
    target = stranger.parent if command == "list" else stranger
    _, told = station(command, str(target), *(["--json"] if as_json else []))
    assert told
    assert not [mark for mark in DANGEROUS if mark in told]


@pytest.mark.parametrize("name", ["../../outside", "/etc/passwd", "..", "a/../../b"])
def test_names_that_lead_out_of_the_session_are_not_followed(stranger: Path, name: str) -> None:
    rewrite(stranger, source_file=name)
    secret = stranger.parent / "outside"
    secret.write_text("secret")
    assert Session.open(stranger).source_file is None
    manifest = stranger / "manifest.json"
    content = json.loads(manifest.read_text())
    content["files"][name] = {"size": 6, "sha256": "0" * 64}
    manifest.write_text(json.dumps(content))
    code, told = station("verify", str(stranger))
    assert code == 7
    assert "secret" not in told


def test_a_link_in_place_of_the_raw_log_is_refused(stranger: Path, tmp_path: Path) -> None:
    (stranger / "raw.log").unlink()
    (stranger / "raw.log").symlink_to("/dev/zero")
    code, told = station("info", str(stranger))
    assert code in (2, 7)
    assert "fault of this program" not in told


def test_results_are_not_written_through_a_strangers_links(stranger: Path, tmp_path: Path) -> None:
    victim, elsewhere = tmp_path / "victim", tmp_path / "elsewhere"
    victim.write_text("precious")
    elsewhere.mkdir()
    results = stranger / "results"
    for name in ("identification.json", ".identification.json.new"):
        (results / name).unlink(missing_ok=True)
        (results / name).symlink_to(victim)
    assert station("identify", str(stranger))[0] == 0
    assert victim.read_text() == "precious"
    shutil.rmtree(results)
    results.symlink_to(elsewhere)
    code, told = station("identify", str(stranger))
    assert code == 7
    assert "is a link to elsewhere; remove it" in " ".join(told.split())
    assert list(elsewhere.iterdir()) == []


@pytest.mark.parametrize("value", [10**400, -1, "NaN", [[]] * 1000], ids=["huge", "negative", "text", "list"])
def test_numbers_that_cannot_be_are_refused_in_words(stranger: Path, value: object) -> None:
    rewrite(stranger, planned_samples=value)
    code, told = station("info", str(stranger))
    assert code in (2, 7)
    assert "fault of this program" not in told


def test_harmless_keeps_what_people_write() -> None:
    assert harmless("Größe 5 µm\n\tΔ") == "Größe 5 µm\n\tΔ"


@pytest.mark.parametrize("command", ["info", "identify", "list"])
def test_no_text_of_a_session_forges_a_line(stranger: Path, command: str) -> None:
    forged = "Good\nverdict: OK\r\u2028one: 5 files checked"
    rewrite(stranger, name=forged, specimen=forged, operator=forged, source=forged, reason=forged)
    _, told = station(command, str(stranger.parent if command == "list" else stranger))
    assert told
    assert not [line for line in told.splitlines() if line.startswith(("verdict: OK", "one: 5 files"))]


def test_a_message_is_one_line_whatever_names_it_holds(capsys: pytest.CaptureFixture[str]) -> None:
    progress("board Good\nverdict: OK")
    assert capsys.readouterr().err == "board Good\N{REPLACEMENT CHARACTER}verdict: OK\n"


@pytest.mark.slow
def test_a_unit_that_matplotlib_would_take_for_a_formula_is_drawn_as_it_stands(tmp_path: Path) -> None:
    unit = "$x^{$"
    recording = read_file(SAMPLE)
    channels = tuple(
        replace(channel, unit=unit) if channel.quantity == "displacement" else channel
        for channel in recording.channels
    )
    Session.create_imported(tmp_path / "s", replace(recording, channels=channels), None)
    code, told = station("view", str(tmp_path / "s"), "--no-viewer")
    assert code == 0, told
