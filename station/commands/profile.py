"""`station profile`: listen to a board that prints lines, say what comes, and keep what it means."""

from typing import TYPE_CHECKING

import click

from station.commands.options import BAUD, COLUMNS, JSON, POSITIVE, UNITS, argument, declared, option
from station.output import next_line, print_json, progress, screen
from station.settings import Settings

if TYPE_CHECKING:
    from daq.sources.line_format import LineFormat, Sample


@declared("profile")
def command(
    settings: Settings,
    name: str | None = argument(required=False),
    port: str = option("Port of the board, or a file that grows.", required=True, metavar="URL"),
    columns: dict[str, str | int] = COLUMNS,
    units: dict[str, str] = UNITS,
    rate: float | None = option("Rate, where it is known.", type=POSITIVE, metavar="HZ"),
    baud: int | None = BAUD,
    as_json: bool = JSON,
) -> None:
    """Listen to a board that prints numbers, a line a sample, and show what comes.

    With NAME what the lines mean is kept, for `station capture --profile
    NAME`. What cannot be found out is said by --column, --unit and --rate.
    """
    from daq.sources.line_format import describe_columns, find_format, profile_file, save_profile
    from daq.sources.line_source import LineSource
    from daq.sources.open_source import LineOptions, open_bytes
    from station.operations.line_boards import profiles_of

    console = screen()
    if name is not None:
        profile_file(name, profiles_of(settings))
    told = LineOptions(None, columns, units, rate, baud)

    def decide(sample: "Sample") -> "LineFormat":
        if not as_json:
            console.print(f"{len(sample.arrivals)} lines: {describe_columns(sample)}", markup=False)
        return find_format(sample, columns, units, rate).model_copy(update={"baud": baud})

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
    for channel in source.form.channels:
        scale = f"one is {channel.scale:g} {channel.unit}"
        console.print(f"{channel.quantity}: column {channel.column}, {scale}", markup=False)
    for remark in found.remarks:
        console.print(f"time: {remark}", markup=False)
    told_name = name or "NAME"
    if kept is not None:
        progress(f"kept: {kept}")
        click.echo(next_line("capture", "--port", port, "--profile", told_name))
    else:
        click.echo(f"{next_line('profile', told_name, '--port', port)} (the same options keep it)")
