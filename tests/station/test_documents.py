"""The documents keep up with the program: every command and option they name exists, every code, every setting."""

import re
import tomllib
from pathlib import Path

import pytest

from station import exits
from station.cli import COMMANDS, station
from station.settings import Settings

ROOT = Path(__file__).resolve().parent.parent.parent
PAGES = (ROOT / "README.md", ROOT / "docs" / "commands.md")


def spoken_commands():
    for page in PAGES:
        for line in page.read_text(encoding="utf-8").splitlines():
            for found in re.findall(r"(?:^|`)station ([a-z][^`#]*)", line):
                yield found.strip()


@pytest.mark.parametrize("line", sorted(set(spoken_commands())))
def test_every_command_and_option_that_is_told_exists(line):
    name, *words = line.split()
    command = station.get_command(None, name)
    assert command is not None
    known = {option for parameter in command.params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= known | {"--help"}


def test_the_exit_codes_of_the_readme_are_those_of_the_program():
    text = PAGES[0].read_text(encoding="utf-8")
    told = {int(code): meaning for code, meaning in re.findall(r"^\| (\d+) \| (.+) \|$", text, re.MULTILINE)}
    assert told == exits.MEANING


def test_the_settings_of_the_page_are_the_defaults():
    page = PAGES[1].read_text(encoding="utf-8")
    block = re.search(r"```toml\n(.*?)```", page, re.DOTALL).group(1)
    assert Settings.model_validate(tomllib.loads(block)) == Settings()
    with_all = tomllib.loads(re.sub(r"^# ", "", block, flags=re.MULTILINE))
    for section, model in (("specimen", Settings().specimen), ("capture", Settings().capture)):
        assert set(with_all[section]) == set(type(model).model_fields)


def test_every_command_is_in_the_pages():
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [entry.name for entry in COMMANDS if f"{entry.name}" not in text] == []


def test_links_and_pictures_lead_somewhere():
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"
