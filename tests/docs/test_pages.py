"""The pages keep up with the program: what they name exists: commands, options, codes, settings, modules, links."""

import importlib
import inspect
import re
import tomllib

import pytest
from contracts import ROOT

import identify
from identify.effects.library import BASE, LIBRARY
from identify.effects.sensor_fault import SensorFault
from station import exits
from station.cli import COMMANDS, station
from station.settings import Settings

DOCS = ROOT / "docs"
PAGES = tuple(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")) + tuple(
    sorted(DOCS.rglob("*.md"))
)
COMMANDS_PAGE = DOCS / "commands.md"
PACKAGES = "firmware_protocol|daq|identify|station|mocks"
ON_SITE = {"index.md": "README.md", "contributing.md": "CONTRIBUTING.md", "changelog.md": "CHANGELOG.md"}
OUR_FILES = {path.name for package in PACKAGES.split("|") for path in (ROOT / package).rglob("*.py")}
MADE_UP = {"fit_problem.py", "fit_floor.py", "my_effects.py"}

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())


def commands_named():
    """Every line of code on a page that calls `station`: in a block, or between backticks."""
    for page in PAGES:
        in_block = False
        for line in page.read_text(encoding="utf-8").splitlines():
            in_block ^= line.startswith("```")
            is_code = in_block or line.startswith("    ")
            found = re.findall(r"^ *station ([a-z][^#]*)" if is_code else r"`station ([a-z][^`#]*)", line)
            yield from (command.strip() for command in found)


def modules_named(text):
    """Every path of a module or folder of ours, and every dotted name, between backticks."""
    paths = re.findall(rf"`((?:{PACKAGES})/[\w/]+(?:\.py)?)`", text)
    names = re.findall(rf"`((?:{PACKAGES})(?:\.\w+)+)`", text)
    return paths, [name for name in names if not name.endswith(".py")]


def resolves(name):
    """Whether a dotted name can be imported: a module, or something in one."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:length]))
        except ModuleNotFoundError:
            continue
        for part in parts[length:]:
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


@pytest.mark.parametrize("line", sorted(set(commands_named())))
def test_every_command_and_option_on_a_page_exists(line):
    name, *words = line.split()
    command = station.get_command(None, name)
    assert command is not None
    known = {option for parameter in command.params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= known | {"--help"}


def test_every_command_has_a_line_on_a_page():
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [name for name in COMMANDS if f"station {name}" not in text] == []


def test_every_make_target_on_a_page_exists():
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for page in PAGES:
        named = set(re.findall(r"(?:^|`)make (\w+)(?=`| |$)", page.read_text(encoding="utf-8"), re.MULTILINE))
        assert named <= targets, page.name


def test_the_lines_for_a_notebook_are_those_that_the_package_shows():
    block = re.search(
        r"```python\n(import identify\n.*?)```", PAGES[0].read_text(encoding="utf-8"), re.DOTALL
    )[1]
    assert block.strip() in inspect.cleandoc(identify.__doc__).replace("\n    ", "\n")


def test_the_exit_codes_of_the_page_are_those_of_the_program():
    text = COMMANDS_PAGE.read_text(encoding="utf-8")
    shown = {int(code): meaning for code, meaning in re.findall(r"^\| (\d+) \| (.+) \|$", text, re.MULTILINE)}
    assert shown == exits.MEANING


def test_the_settings_of_the_page_are_the_defaults():
    page = COMMANDS_PAGE.read_text(encoding="utf-8")
    block = re.search(r"```toml\n(.*?)```", page, re.DOTALL).group(1)
    assert Settings.model_validate(tomllib.loads(block)) == Settings()
    with_all = tomllib.loads(re.sub(r"^# ", "", block, flags=re.MULTILINE))
    for section, model in (("specimen", Settings().specimen), ("capture", Settings().capture)):
        assert set(with_all[section]) == set(type(model).model_fields)


@each_page
def test_every_module_on_a_page_exists(page):
    paths, names = modules_named(page.read_text(encoding="utf-8"))
    assert [path for path in paths if not (ROOT / path).exists()] == []
    assert [name for name in names if not resolves(name)] == []
    files = re.findall(r"`(\w+\.py)`", page.read_text(encoding="utf-8"))
    assert [file for file in files if file not in OUR_FILES and file not in MADE_UP] == []


@pytest.mark.parametrize("name", ["identify.fitting.descent", "daq.told", "identify.model.model.Sum"])
def test_a_name_that_is_gone_is_found_out(name):
    assert not resolves(name)
    assert modules_named(f"see `{name}`") == ([], [name])


def headings(page):
    """The places within a page that a link may name, as the site names them."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    plain = (re.sub(r"[^\w\s-]", "", title).strip().lower() for title in titles)
    return {re.sub(r"[-\s]+", "-", title) for title in plain}


def broken_links(page, text):
    """The links of a page that lead nowhere; root pages have two names, one of them on the site."""
    for target, place in re.findall(r"\]\(([^)#:\s]*)(?:#([^)]*))?\)", text):
        file = page.parent / target if target else page
        file = ROOT / ON_SITE.get(file.name, file.name) if not file.exists() else file
        if not file.exists() or (place and place not in headings(file)):
            yield f"{target}#{place}"


@each_page
def test_links_and_pictures_lead_somewhere(page):
    assert list(broken_links(page, page.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize("link", ["nowhere.md", "method.md#nowhere", "#nowhere", "pictures/nowhere.png"])
def test_a_link_that_leads_nowhere_is_found_out(link):
    assert list(broken_links(DOCS / "effects.md", f"see [this]({link}) and [that](method.md#symbols)"))


def test_every_page_is_in_the_navigation():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = [page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md")]
    assert [page for page in pages if f" {page}\n" not in navigation] == []


def test_the_first_page_counts_the_effects_of_the_library():
    faults = sum(isinstance(effect, SensorFault) for effect in LIBRARY)
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert f"one of {len(LIBRARY) - len(BASE) - faults} physical effects or {faults} sensor faults" in readme
