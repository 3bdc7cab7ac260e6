"""The command line: it parses, calls one command and turns what went wrong into a sentence.

A command is one file in `station/commands/`, imported only when it is called, so that `station --help`
answers at once. To add a command: write the file, add its name to COMMANDS.
"""

import gc
import importlib
import io
import re
import sys
import traceback
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

import click

from station import exits

COMMANDS = (
    "demo", "doctor", "ports", "capture", "guide", "profile", "replay", "import", "identify", "diagnose", "refine",
    "validate", "compare", "effects", "workbench", "view", "report", "table", "campaign", "export", "list", "info",
    "verify", "recover",
)  # fmt: skip
"""Each command, in the order in which a newcomer needs them; the first line of its module says what it does."""

MODULES = {"import": "import_", "list": "list_"}
"""The modules of `station.commands` that are not called as their commands, whose names Python has taken."""


class LazyGroup(click.Group):
    """A group that knows its commands by name and imports one when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order in which a newcomer needs them."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the module of a command and return the command, or None when there is none of that name."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"station.commands.{MODULES.get(cmd_name, cmd_name)}")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command of a line, which is kept as it was typed; one that is mistyped gets the nearest names."""
        from station.output import TYPED

        ctx.meta[TYPED] = list(args)
        if args and not args[0].startswith("-") and args[0] not in COMMANDS:
            from station.suggestions import did_you_mean

            ctx.fail(f"there is no command '{args[0]}'{did_you_mean(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands without importing any of them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, _help_of(name)) for name in COMMANDS])


def _help_of(name: str) -> str:
    """Return what a command does, from the first line of its module, which is not imported for that."""
    module = files("station.commands").joinpath(f"{MODULES.get(name, name)}.py")
    words = module.read_text(encoding="utf-8").splitlines()[0].partition("`: ")[2].strip('"')
    return f"{words[:1].upper()}{words[1:]}"


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 80})
@click.version_option(package_name="free-decay-station", prog_name="station")
@click.option(
    "--settings", "settings_file", metavar="FILE", help="Settings (default: ./station.toml if it exists)."
)
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.pass_context
def station(ctx: click.Context, settings_file: str | None, debug: bool) -> None:
    """Release a mass on springs, record it, and learn which forces act on it.

    Begin with `station demo`, or with `station import FILE` and
    `station identify SESSION`. SESSION is a session's folder, its name or the
    beginning of it, `last` (the newest), or a data file.
    """
    ctx.obj = settings_file


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit with the code that says how it ended.

    What a command imports is no garbage: looking for it there at every 700 objects would take a sixth of a second.
    """
    from station.output import say_in_one_line
    from station.working_folder import import_nothing_from_it

    gc.set_threshold(100_000)
    import_nothing_from_it()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal with few letters shows "?" for what it lacks
    say_in_one_line()
    given = list(sys.argv[1:] if arguments is None else arguments)
    sys.exit(run(given))


def run(arguments: list[str]) -> int:
    """Run the command line; return its exit code instead of leaving the process."""
    try:
        result: Any = station.main(args=arguments, prog_name="station", standalone_mode=False)
        sys.stdout.flush()
        return result if isinstance(result, int) else exits.DONE
    except (click.exceptions.Abort, KeyboardInterrupt) as error:
        cause = error.__cause__ or error
        return _failed(cause, exits.INTERRUPTED, _interrupted(cause), arguments)
    except click.ClickException as error:
        return _failed(error, exits.USAGE, _usage_sentence(error, arguments), arguments)
    except BrokenPipeError:  # the reader of a pipe has left, as `head` does
        sys.stderr.close()
        return exits.DONE
    except Exception as error:
        return _failed(error, exits.code_of(error), _kept(error), arguments)


def _interrupted(error: BaseException) -> str:
    """Say what an interruption has left: what was received of a recording, or what was there before."""
    folder = getattr(error, "session", None)
    if str(error):
        return str(error)
    if folder is None:
        return "interrupted; no result was kept, and the recordings are as they were"
    from station.output import command_line

    return f"interrupted; what was received is kept in {folder} (look at it: {command_line('info', folder)})"


def _kept(error: Exception) -> str:
    """Write an error as a sentence, with where the data are when one of the acquisition left some."""
    sentence = exits.sentence_of(error, "; run `station --debug ...` again and report what it prints")
    folder = getattr(error, "session", None)
    return sentence if folder is None or str(folder) in sentence else f"{sentence} (kept: {folder})"


def _usage_sentence(error: click.ClickException, arguments: list[str]) -> str:
    sentence = error.format_message().rstrip(".")
    sentence = in_plain_words(f"{sentence[:1].lower()}{sentence[1:]}")
    context = getattr(error, "ctx", None)
    named = next((word for word in arguments if word in COMMANDS), "")
    where = context.command_path if context is not None else f"station {named}".strip()
    return f"{sentence}; see `{where} --help`"


_BOUNDS = {">": "above", ">=": "at least", "<": "below", "<=": "at most"}
_TURNED = {"<": ">", "<=": ">="}


def in_plain_words(sentence: str) -> str:
    """Return the refusal of a number with its bounds in words: "-3.0 is not in the range x>0." becomes "must be above 0"."""
    found = re.search(r"(\S+) is not in the range (?:(\S+?)(<=?))?x(?:([<>]=?)(\S+))?$", sentence)
    if found is None:
        return re.sub(
            r"is not a valid (float|integer)(?: range)?$",
            lambda kind: "is no number" if kind.group(1) == "float" else "is no whole number",
            sentence,
        )
    given, low, first, second, other = found.groups()
    bounds = [f"{_BOUNDS[_TURNED[first]]} {low}"] if low else []
    bounds += [f"{_BOUNDS[second]} {other}"] if other else []
    return f"{sentence[: found.start()]}it is {given}, and must be {' and '.join(bounds)}"


def _failed(error: BaseException, code: int, sentence: str, arguments: list[str]) -> int:
    if "--debug" in arguments:
        traceback.print_exception(error)
    if "--json" in arguments and not getattr(error, "reported", False):
        from station.output import print_json

        known = {"message": sentence, "exit_code": code, "meaning": exits.MEANING.get(code, "")}
        print_json({"error": known | getattr(error, "details", {})})
    from station.output import progress

    progress(f"station: {sentence}")
    return code
