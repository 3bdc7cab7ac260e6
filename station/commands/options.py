"""Options that several commands share."""

from pathlib import Path

import click

MODEL = click.option(
    "--model",
    "model_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Begin with this model instead of stiffness, dry and viscous friction.",
)
EFFECTS = click.option(
    "--effects",
    "effects_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Your own effects (Python).",
)
GAIN = click.option(
    "--gain-uncertainty",
    "gain_percent",
    type=click.FloatRange(0, 50),
    metavar="PERCENT",
    help="What the calibrations leave open between the channels.",
)
MASS_INSTEAD = click.option(
    "--mass",
    type=click.FloatRange(min=0, min_open=True),
    metavar="KG",
    help="Mass, instead of the session's.",
)
MASS = click.option(
    "--mass", type=click.FloatRange(min=0, min_open=True), metavar="KG", help="Mass (kg m^2 for angles)."
)
MASS_STD = click.option(
    "--mass-std", type=click.FloatRange(min=0), metavar="KG", help="Standard error of the mass."
)
NO_VIEWER = click.option("--no-viewer", is_flag=True, help="Do not open the viewer.")
CONDITIONS = click.option(
    "--condition",
    "conditions",
    multiple=True,
    metavar="NAME=NUMBER",
    help='Known of the test, as "temperature [degC]=21.5".',
)
