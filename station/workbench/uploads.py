"""Names of files that strangers gave: nothing in them may lead out of the folder where they are put."""

import re

LONGEST = 100


def plain_name(given: str) -> str:
    """Return the last part of a name with letters, digits, dots and dashes only; "recording" where nothing is left."""
    last = re.split(r"[/\\]", given)[-1]
    stem, dot, ending = last.rpartition(".")
    if not dot:
        stem, ending = last, ""
    stem = re.sub(r"[^\w.-]+", "_", stem).strip("._")[:LONGEST] or "recording"
    ending = re.sub(r"[^A-Za-z0-9]+", "", ending)[:10]
    return f"{stem}.{ending}" if ending else stem
