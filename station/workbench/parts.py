"""The parts of the page that templates write: every text in them is escaped, whoever wrote it."""

from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, StrictUndefined

from identify.formatting import plain_name, sentence_case
from identify.residual import floor_words, times
from station.text.diagnosis_text import found_in_sensor, not_distinguishable, verdict_line
from station.text.guide_text import odds_before, percent
from station.text.layout import sentence
from station.text.numbers import typeset, with_names
from station.workbench.statements import explains, share


@cache
def _macros() -> Any:
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "plain": plain_name, "begun": sentence_case, "times": times, "floor": floor_words, "typeset": typeset,
        "named": with_names, "share": share, "explains": explains, "sentence": sentence,
        "alike": not_distinguishable, "fault": found_in_sensor, "verdict": verdict_line,
        "percent": percent, "odds_before": odds_before,
    }  # fmt: skip
    text = files("station.workbench").joinpath("parts.html").read_text(encoding="utf-8")
    return environment.from_string(text).module


def part(name: str, *values: Any) -> str:
    """Write a part, a macro of parts.html, as HTML."""
    return str(getattr(_macros(), name)(*values))
