"""`station profile`: listen to a board that prints lines, say what comes, and keep what it means."""

import sys
from typing import TYPE_CHECKING

import click

from station.commands.options import BAUD, COLUMNS, UNITS, pass_settings
from station.output import json_option, print_json, progress, screen
from station.settings import Settings

if TYPE_CHECKING:
    from daq.sources.line_format import LineFormat, Sample
    from daq.sources.open_source import LineOptions


@click.command("profile")
@click.argument("name", required=False)
@click.option("--port", required=True, metavar="URL", help="Port of the board, or a file that grows.")
@COLUMNS
@UNITS
@click.option(
    "--rate", type=click.FloatRange(min=0, min_open=True), metavar="HZ", help="Rate, where it is known."
)
@BAUD
@json_option
@pass_settings
def command(
    settings: Settings,
    name: str | None,
    port: str,
    columns: dict[str, str | int],
    units: dict[str, str],
    rate: float | None,
    baud: int | None,
    as_json: bool,
) -> None:
    """Listen to a board that prints numbers, a line a sample, and show what comes.

    With NAME what the lines mean is kept, for `station capture --profile
    NAME`. At a terminal you are asked for what cannot be found out.
    """
    from daq.sources.line_source import LineSource
    from daq.sources.open_source import LineOptions, open_bytes
    from daq.sources.profiles import profile_file, save_profile
    from station.operations.line_boards import profiles_of
    from station.text.lines_text import show_format, show_lines
    from station.text.next_step import next_line

    if name is not None:
        profile_file(name, profiles_of(settings))
    told = LineOptions(None, columns, units, rate, baud)

    def decide(sample: "Sample") -> "LineFormat":
        if not as_json:
            show_lines(screen(), sample)
        return _decided(sample, told, may_ask=not as_json).model_copy(update={"baud": baud})

    progress(f"listening to {port} for some seconds")
    source = LineSource(open_bytes(port, told), decide)
    found = source.describe()
    source.close()
    kept = None if name is None else save_profile(source.form, name, profiles_of(settings))
    if as_json:
        print_json(
            {
                "format": source.form.model_dump(mode="json"),
                "rate_hz": found.rate_hz,
                "remarks": list(found.remarks),
                "profile": None if kept is None else str(kept),
            }
        )
        return
    show_format(screen(), source.form, found)
    told_name = name or "NAME"
    if kept is not None:
        progress(f"kept: {kept}")
        click.echo(next_line("capture", "--port", port, "--profile", told_name))
    else:
        click.echo(f"{next_line('profile', told_name, '--port', port)} (the same options keep it)")


def _decided(sample: "Sample", options: "LineOptions", *, may_ask: bool) -> "LineFormat":
    """Settle what the lines mean, from the options and, at a terminal, from what the operator answers."""
    from daq.errors import SettingsError
    from daq.sources.line_format import find_format

    while True:
        try:
            return find_format(sample, options.columns, options.units, options.rate_hz)
        except SettingsError as refusal:
            if not (may_ask and sys.stdin.isatty() and sys.stderr.isatty()):
                raise
            options = _asked(str(refusal), options)


def _asked(refusal: str, options: "LineOptions") -> "LineOptions":
    """Return the options with what the operator answers."""
    from dataclasses import replace

    progress(refusal)
    quantity = click.prompt(
        "Which quantity do you know?",
        type=click.Choice(["displacement", "velocity", "acceleration", "force", "time", "counter"]),
        default="displacement",
        err=True,
    )
    column = click.prompt("Its column (number from 1, or name)", err=True)
    unit = (
        ""
        if quantity == "counter"
        else click.prompt("Its unit, or what one count is (0.005 mm)", default="", err=True)
    )
    units = dict(options.units) | ({quantity: unit} if unit else {})
    return replace(options, columns=dict(options.columns) | {quantity: column}, units=units)
