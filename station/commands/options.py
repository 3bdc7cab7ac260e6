"""The declaration of a command, and the options that several commands share."""

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any

import click

from station.exits import UsageProblem
from station.settings import load_settings

FILE = click.Path(path_type=Path)
POSITIVE = click.FloatRange(min=0, min_open=True)
WITHIN_AN_HOUR = click.FloatRange(0, 3600, min_open=True)
KINDS: dict[Any, dict[str, Any]] = {
    bool: {"is_flag": True},
    Path: {"type": FILE},
    Path | None: {"type": FILE},
    float: {"type": float},
    float | None: {"type": float},
    int | None: {"type": int},
}
"""What `click` is told of an option by the type of its parameter."""


def declared(
    name: str, others: Mapping[str, tuple[Any, Any]] | None = None, *, reports: bool = True
) -> Callable[[Callable[..., Any]], click.Command]:
    """Make a command of a function whose parameters have the options and arguments that give them as their defaults.

    `others` are options by the name under which they come among the function's keywords, each after its type. What
    `reports` has `--json`, for `asked_for_json`. A parameter `settings` gets the settings; UsageProblem where the file that
    was named is none.
    """

    def made(function: Callable[..., Any]) -> click.Command:
        parameters = inspect.signature(function).parameters
        by_name = "settings" in parameters

        @click.pass_obj
        @wraps(function)
        def called(file: str | None, /, *, as_json: bool = False, **given: Any) -> Any:
            return function(load_settings(file), **given) if by_name else function(**given)

        command = click.command(name)(called)
        for key, (kind, declare) in (others or {}).items():
            parameter = inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, annotation=kind)
            command.params.append(declare(parameter))
        for parameter in parameters.values():
            if parameter.default is not parameter.empty:
                command.params.append(parameter.default(parameter))
        if reports:
            command.params.append(
                click.Option(("--json", "as_json"), is_flag=True, help="One JSON object on stdout.")
            )
        return command

    return made


def option(help: str, *names: str, **said: Any) -> Any:
    """Declare an option in the place of a parameter's default, else as `click.option`.

    Without `names` it has the parameter's; the parameter's type says what it takes, and makes of a `bool` a flag.
    """

    def declare(parameter: inspect.Parameter) -> click.Parameter:
        spelled = names or (f"--{parameter.name.replace('_', '-')}",)
        kind = KINDS.get(parameter.annotation, {})
        return click.Option((*spelled, parameter.name), help=help, **{**kind, **said})

    return declare


def argument(**said: Any) -> Any:
    """Declare an argument in the place of a parameter's default, else as `click.argument`."""

    def declare(parameter: inspect.Parameter) -> click.Parameter:
        return click.Argument((parameter.name,), **{**KINDS.get(parameter.annotation, {}), **said})

    return declare


def by_quantity(context: click.Context, parameter: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Split options of the form QUANTITY=VALUE. Raises UsageProblem for anything else."""
    found = {}
    for pair in given:
        name, separator, value = (part.strip() for part in pair.partition("="))
        if not separator or not name or not value:
            raise UsageProblem(f"{parameter.opts[0]} {pair}: write QUANTITY=VALUE, as displacement=2")
        found[name] = value
    return found


def columns_by_quantity(
    context: click.Context, parameter: click.Parameter, given: tuple[str, ...]
) -> dict[str, str | int]:
    """Split options of the form QUANTITY=COLUMN, the number of a column or its name."""
    found = by_quantity(context, parameter, given)
    return {name: int(column) if column.isdigit() else column for name, column in found.items()}


SESSION = argument()
SESSIONS = argument(nargs=-1, required=True, metavar="SESSION...")
MODEL = option(
    "A model file; or `refined`, `identified`, `usual` (spring, dry, viscous friction).",
    "--model",
    metavar="FILE",
)
EFFECTS = option("Your own effects (Python).", "--effects", metavar="FILE")
MASS = option("Mass (kg m^2 for angles).", "--mass", type=POSITIVE, metavar="KG")
MASS_STD = option("Standard error of the mass.", "--mass-std", type=click.FloatRange(min=0), metavar="KG")
FULL = option("Print all that is known, not only the result.", "--full")
NO_VIEWER = option("Do not use the viewer.", "--no-viewer")
SPECIMEN = option("What is tested.", "--specimen")
OPERATOR = option("Who tests it.", "--operator")
CONDITIONS = option(
    'A known condition of the test, as "temperature [degC]=21.5".',
    "--condition",
    multiple=True,
    metavar="NAME=NUMBER",
)
VARIES = option(
    "What differs between the sessions of one rig, as stiffness,inertia.",
    "--varies",
    metavar="NAME,...",
    callback=lambda context, parameter, value: tuple(value.split(",")) if value else (),
)
COLUMNS = option(
    "Column of a quantity (time, displacement, velocity, acceleration, force): its name, its number from 1, or none.",
    "--column",
    multiple=True,
    metavar="QUANTITY=COLUMN",
    callback=columns_by_quantity,
)
UNITS = option(
    "Unit of a column, as mm, deg, g, '0.005 mm'.",
    "--unit",
    multiple=True,
    metavar="QUANTITY=UNIT",
    callback=by_quantity,
)
BAUD = option("Baud rate of the lines (115200).", "--baud", type=click.IntRange(min=50), metavar="BAUD")


RELEASE = {
    "mass": (float, MASS),
    "mass_std": (float, MASS_STD),
    "duration": (float, option("Seconds after the release (8).", type=WITHIN_AN_HOUR, metavar="S")),
    "rate": (float, option("Sampling rate (256).", type=click.FloatRange(5, 20000), metavar="HZ")),
    "patience": (float, option("Seconds to wait for the release (60).", type=WITHIN_AN_HOUR, metavar="S")),
    "specimen": (str, SPECIMEN),
    "operator": (str, OPERATOR),
    "conditions": (tuple[str, ...], CONDITIONS),
}
"""What can be said of a release, for `declared`."""


def new_session_option(text: str) -> Any:
    """Declare the option `--session`: where what is made goes, as the help `text` says."""
    return option(text, "--session", metavar="FOLDER")
