"""The contents and the meaning of a board's lines, in a terminal."""

import numpy as np
from rich.console import Console

from daq.sources.line_format import LineFormat, Sample
from daq.sources.source import SourceDescription
from station.text.content import Table
from station.text.layout import show_parts


def show_lines(console: Console, sample: Sample) -> None:
    """Print the columns with their last number, range and name."""
    names = sample.header if len(sample.header) == len(sample.columns) else tuple(sample.columns)
    rows = []
    for number, (name, values) in enumerate(zip(names, sample.columns.values(), strict=True), 1):
        known = values[np.isfinite(values)]
        sizes = (known[-1], known.min(), known.max(), known.std()) if len(known) else ()
        rows.append((str(number), name, *(f"{size:.6g}" for size in sizes), *["-"] * (4 - len(sizes))))
    head = ("column", "name", "last", "smallest", "largest", "standard deviation")
    caption = f"{len(sample.arrivals)} lines in {sample.arrivals[-1] - sample.arrivals[0]:.2g} s"
    show_parts(console, [Table(caption, head, tuple(rows), texts=2)])


def show_format(console: Console, form: LineFormat, found: SourceDescription) -> None:
    """Print what the lines mean."""
    for channel in form.channels:
        console.print(
            f"{channel.quantity}: column {channel.column}, one is {channel.scale:g} {channel.unit}",
            markup=False,
        )
    for remark in found.remarks:
        console.print(f"time: {remark}", markup=False)
