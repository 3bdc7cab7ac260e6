"""Options that several commands share."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

import click

from station.exits import UsageProblem
from station.settings import load_settings

FILE = click.Path(path_type=Path)
POSITIVE = click.FloatRange(min=0, min_open=True)

Given = TypeVar("Given", str, tuple[str, ...])


def pass_settings(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the settings as its first argument; UsageProblem where the file that was named is none."""

    @click.pass_obj
    @wraps(command)
    def with_settings(file: str | None, /, *args: Any, **given: Any) -> Any:
        return command(load_settings(file), *args, **given)

    return with_settings


def existing(
    what: str = "session or data file", *, or_all: bool = False
) -> Callable[[click.Context, click.Parameter, Given], Given]:
    """Make what refuses at once an argument that is not there and no session's name where the settings say.

    `what` it may be is said in the refusal; with `or_all` the settings' folder of sessions passes, there or not.
    """

    def check(context: click.Context, parameter: click.Parameter, value: Given) -> Given:
        from station.results.session_names import refuse_unknown

        sessions = load_settings(context.obj).sessions
        for name in (value,) if isinstance(value, str) else value:
            if not (or_all and name == str(sessions)):
                refuse_unknown(name, sessions, what)
        return value

    return check


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


def known_effect(context: click.Context, parameter: click.Parameter, value: str | None) -> str | None:
    """Refuse at once an effect that is not in the library; a formula, and names of a file of effects, pass."""
    from station.suggestions import MEASURED_CURVE, effect_names, no_such_effect

    if value is None or "=" in value or context.params.get("effects_file"):
        return value
    names = (*effect_names(), MEASURED_CURVE)
    if value not in names:
        raise no_such_effect(value, names)
    return value


SESSION = click.argument("session", callback=existing())
SESSIONS = click.argument("sessions", nargs=-1, required=True, metavar="SESSION...", callback=existing())
MODEL = click.option(
    "--model",
    "model_file",
    type=FILE,
    metavar="FILE",
    help="A model file; or `refined`, `identified`, `usual` (spring, dry, viscous friction).",
)
EFFECTS = click.option(
    "--effects",
    "effects_file",
    type=FILE,
    metavar="FILE",
    is_eager=True,
    help="Your own effects (Python).",
)
GAIN = click.option(
    "--gain-uncertainty",
    "gain_percent",
    type=click.FloatRange(0, 50),
    metavar="PERCENT",
    help="Uncertainty of the gain between the channels.",
)
MASS_INSTEAD = click.option("--mass", type=POSITIVE, metavar="KG", help="Mass, instead of the session's.")
MASS = click.option("--mass", type=POSITIVE, metavar="KG", help="Mass (kg m^2 for angles).")
MASS_STD = click.option(
    "--mass-std", type=click.FloatRange(min=0), metavar="KG", help="Standard error of the mass."
)
FULL = click.option("--full", is_flag=True, help="Print all that is known, not only the result.")
NO_VIEWER = click.option("--no-viewer", is_flag=True, help="Do not open the viewer.")
DURATION = click.option(
    "--duration",
    type=click.FloatRange(0, 3600, min_open=True),
    metavar="S",
    help="Seconds after the release (8).",
)
RATE = click.option("--rate", type=click.FloatRange(5, 20_000), metavar="HZ", help="Sampling rate (256).")
PATIENCE = click.option(
    "--patience",
    type=click.FloatRange(0, 3600, min_open=True),
    metavar="S",
    help="How long to wait for the release (60).",
)
SPECIMEN = click.option("--specimen", help="What is tested.")
OPERATOR = click.option("--operator", help="Who tests it.")
CONDITIONS = click.option(
    "--condition",
    "conditions",
    multiple=True,
    metavar="NAME=NUMBER",
    help='A known condition of the test, as "temperature [degC]=21.5".',
)
VARIES = click.option(
    "--varies",
    metavar="NAME,...",
    callback=lambda context, parameter, value: tuple(value.split(",")) if value else (),
    help="What differs between the sessions of one rig, as stiffness,inertia.",
)
COLUMNS = click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="QUANTITY=COLUMN",
    callback=columns_by_quantity,
    help="Column of a quantity (time, displacement, velocity, acceleration, force): its name, its number from 1, or none.",
)
UNITS = click.option(
    "--unit",
    "units",
    multiple=True,
    metavar="QUANTITY=UNIT",
    callback=by_quantity,
    help="Unit of a column, as mm, deg, g, '0.005 mm'.",
)
BAUD = click.option(
    "--baud", type=click.IntRange(min=50), metavar="BAUD", help="Baud rate of the lines (115200)."
)


def release_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command what can be said of a release: mass, duration, rate, patience, specimen, operator, conditions."""
    for option in (CONDITIONS, OPERATOR, SPECIMEN, PATIENCE, RATE, DURATION, MASS_STD, MASS):
        command = option(command)
    return command


def new_session_option(text: str) -> Callable[..., Any]:
    """Make the option `--session`, passed on as `folder`: where what is made goes, as the help `text` says."""
    return click.option("--session", "folder", type=FILE, metavar="FOLDER", help=text)
