"""What a board's lines hold and what they mean, in a terminal."""

import numpy as np
from rich.console import Console
from rich.table import Table

from daq.sources.line_format import LineFormat, Sample
from daq.sources.source import SourceDescription


def show_lines(console: Console, sample: Sample) -> None:
    """Print the columns with their last number, range and name."""
    table = Table(box=None, pad_edge=False)
    for heading in ("column", "name", "last", "smallest", "largest", "standard deviation"):
        table.add_column(heading, justify="left" if heading in ("column", "name") else "right")
    names = sample.header if len(sample.header) == len(sample.columns) else tuple(sample.columns)
    for number, (name, values) in enumerate(zip(names, sample.columns.values(), strict=True), 1):
        known = values[np.isfinite(values)]
        cells = (
            [f"{v:.6g}" for v in (known[-1], known.min(), known.max(), known.std())]
            if len(known)
            else ["-"] * 4
        )
        table.add_row(str(number), name, *cells)
    console.print(f"{len(sample.arrivals)} lines in {sample.arrivals[-1] - sample.arrivals[0]:.2g} s")
    console.print(table)


def show_format(console: Console, form: LineFormat, found: SourceDescription) -> None:
    """Print what the lines mean."""
    for channel in form.channels:
        console.print(
            f"{channel.quantity}: column {channel.column}, one is {channel.scale:g} {channel.unit}",
            markup=False,
        )
    for remark in found.remarks:
        console.print(f"time: {remark}", markup=False)
