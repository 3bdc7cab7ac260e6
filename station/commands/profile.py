"""`station profile`: describe a board that prints numbers line by line."""

from typing import TYPE_CHECKING

from station.commands.options import BAUD, COLUMNS, POSITIVE, UNITS, argument, declared, option
from station.output import progress
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
) -> None:
    """Listen to a board that prints numbers, a line a sample, and show what comes.

    With NAME what the lines mean is kept, for `station capture --profile
    NAME`. What cannot be found out is said by --column, --unit and --rate.
    """
    from daq.sources.line_format import describe_columns, find_format, profile_file, save_profile
    from daq.sources.line_source import LineSource
    from daq.sources.open_source import LineOptions, open_bytes
    from station.operations.capturing import profiles_of
    from station.text.content import Told, facts
    from station.text.layout import answer

    if name is not None:
        profile_file(name, profiles_of(settings))
    told = LineOptions(None, columns, units, rate, baud)

    def decide(sample: "Sample") -> "LineFormat":
        progress(f"{len(sample.arrivals)} lines: {describe_columns(sample)}")
        return find_format(sample, columns, units, rate).model_copy(update={"baud": baud})

    progress(f"listening to {port} for some seconds")
    source = LineSource(open_bytes(port, told), decide)
    found = source.describe()
    source.close()
    kept = None if name is None else save_profile(source.form, name, profiles_of(settings))
    document = {
        "format": source.form.model_dump(mode="json"),
        "rate_hz": found.rate_hz,
        "remarks": list(found.remarks),
        "profile": None if kept is None else str(kept),
    }
    rows = [
        (one.quantity, f"column {one.column}, one is {one.scale:g} {one.unit}")
        for one in source.form.channels
    ]
    rows += [("time", remark) for remark in found.remarks]
    if kept is not None:
        progress(f"kept: {kept}")
    step = ("profile", "NAME") if name is None else ("capture", "--profile", name)
    answer(document, Told("", "", facts(rows)), *step, "--port", port)
