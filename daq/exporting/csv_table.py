"""CSV: comment lines with what is known, one line of names with units, then one line a sample."""

import csv
import io

from daq.exporting.exported import Exported


def encode(exported: Exported) -> bytes:
    """Return the table as UTF-8; numbers have as many digits as it takes to read the same ones back."""
    text = io.StringIO()
    for name, fact in exported.all_facts.items():
        text.write(f"# {name}: {one_line(fact)}\n")
    for channel, name in zip(exported.recording.channels, exported.names, strict=True):
        known = exported.channel_facts(channel)
        text.write(f"# {name}: " + ", ".join(f"{k} {one_line(v)}" for k, v in known.items()) + "\n")
    writer = csv.writer(text, lineterminator="\n")
    units = [channel.unit for channel in exported.recording.channels]
    writer.writerow(["time [s]", *(f"{n} [{u}]" for n, u in zip(exported.names, units, strict=True))])
    columns = [[repr(value) for value in exported.time.tolist()]]
    columns += [["" if v != v else repr(v) for v in row.tolist()] for row in exported.samples]
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode()


def one_line(text: str) -> str:
    """Return a text without line breaks and other control characters."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
