"""Installs the station into .venv and says what it does; `make` calls it, and it runs without make as well.

python install.py              the station alone
python install.py --dev        and what its tests need
python install.py --newest     with the newest versions instead of those in constraints.txt
python install.py --launcher   puts the command `station` where a shell finds it
python install.py --remove     takes that command away again
"""

import os
import re
import subprocess
import sys
import time
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
VENV = HERE / os.environ.get("STATION_VENV", ".venv")
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
CONSTRAINTS = HERE / "constraints.txt"
MARK = "# made by `make install` of the Free-Decay Station; `make clean` removes it"
OLDEST = (3, 11)
LARGE_MB = 5.0


def main(arguments: list[str]) -> int:
    """Do what the arguments ask for; return an exit code."""
    if sys.version_info < OLDEST:
        return _refuse(f"Python {OLDEST[0]}.{OLDEST[1]} or later is needed; this is {sys.version.split()[0]}")
    if "--launcher" in arguments:
        return place_launcher()
    if "--remove" in arguments:
        return remove_launcher()
    return install("dev" if "--dev" in arguments else "", newest="--newest" in arguments)


def install(extra: str, newest: bool = False) -> int:
    """Make .venv where there is none, install into it the versions that were tested together, and show what comes."""
    began = time.monotonic()
    print(f"installing the station{' and what its tests need' if extra else ''} into {VENV.name}", flush=True)
    if not (VENV / "pyvenv.cfg").is_file():
        try:
            venv.create(VENV, with_pip=True)
        except subprocess.CalledProcessError:
            return _refuse("Python cannot make an environment here; on Debian: apt install python3-venv")
    code, said = _pip(extra, newest)
    if code != 0 and not newest:
        print(
            "the versions of constraints.txt do not all fit this Python or system; the newest that do are taken"
        )
        code, said = _pip(extra, True)
    if code != 0:
        sys.stderr.write("".join(said[-15:]))
        return _refuse("pip could not install the station; its last words are above")
    print(f"installed in {time.monotonic() - began:.0f} s", flush=True)
    return 0


def _pip(extra: str, newest: bool) -> tuple[int, list[str]]:
    """Let pip install, show what comes, and return its exit code and all that it said."""
    command = [str(BIN / "python"), "-m", "pip", "install", "--disable-pip-version-check"]
    if not newest:
        command += ["--constraint", str(CONSTRAINTS)]
    command += ["--editable", f"{HERE}[{extra}]" if extra else str(HERE)]
    pip = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert pip.stdout is not None
    said, teller = [], Progress()
    for line in pip.stdout:
        said.append(line)
        text = teller.hear(line)
        if text:
            print(text, flush=True)
    return pip.wait(), said


class Progress:
    """What pip says, in few and plain words: each package that the station names, and each large download."""

    def __init__(self) -> None:
        self._reasons = reasons()
        self._shown: set[str] = set()

    def hear(self, line: str) -> str | None:
        """Return what to show for a line of pip's, None for nothing."""
        collecting = re.match(r"Collecting ([\w.-]+)", line)
        if collecting:
            name = _plain(collecting.group(1))
            if name in self._reasons and name not in self._shown:
                self._shown.add(name)
                return f"  {name:<18} {self._reasons[name]}"
        large = re.match(r"\s*Downloading (\w[\w.]*)-\S+ \(([\d.]+) MB\)", line)
        if large and float(large.group(2)) >= LARGE_MB:
            return f"    downloading {float(large.group(2)):.0f} MB of {_plain(large.group(1))}"
        if line.startswith("Installing collected packages:"):
            return f"  putting {line.count(',') + 1} packages in place; this takes a minute"
        return None


def reasons() -> dict[str, str]:
    """Return what each dependency is for, as pyproject.toml says it beside the name (up to a semicolon)."""
    text = (HERE / "pyproject.toml").read_text(encoding="utf-8")
    found = re.findall(r'^\s*"([\w.-]+)[^"]*",\s*#\s*(.+)$', text, re.MULTILINE)
    return {_plain(name): why.split(";")[0] for name, why in found}


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def launcher_folders() -> list[Path]:
    """Return the folders for a user's own commands that the shell looks into, the best first."""
    home = Path.home()
    own = [home / ".local" / "bin", home / "bin"]
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        own.append(Path("/usr/local/bin"))
    looked_into = os.environ.get("PATH", "").split(os.pathsep)
    return [folder for folder in own if str(folder) in looked_into]


def place_launcher() -> int:
    """Put a launcher `station` into the first of those folders; nothing is overwritten."""
    program = BIN / "station"
    if os.name != "nt":
        for folder in launcher_folders():
            file = folder / "station"
            if file.exists() and MARK not in _text(file):
                continue
            try:
                folder.mkdir(parents=True, exist_ok=True)
                file.write_text(f'#!/bin/sh\n{MARK}\nexec "{program}" "$@"\n', encoding="utf-8")
                file.chmod(0o755)
            except OSError:
                continue
            print(f"`station` works in every shell now ({file}; `make clean` removes it)")
            return 0
    print(f'to use `station` in a shell, type there: export PATH="{BIN}:$PATH"')
    return 0


def remove_launcher() -> int:
    """Remove the launcher of this clone; another clone's stays."""
    for folder in launcher_folders():
        file = folder / "station"
        text = _text(file)
        if MARK in text and f'"{BIN / "station"}"' in text:
            file.unlink()
            print(f"removed {file}")
    return 0


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ""


def _refuse(sentence: str) -> int:
    print(f"install: {sentence}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
