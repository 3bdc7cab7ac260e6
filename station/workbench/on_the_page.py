"""Messages as the page shows them: without what is for those who type commands."""

import re

OPTION = re.compile(
    r"""see\ `[^`]+`,\ or\                                             # another command
    |\ \([^()]*--[a-z][^()]*\)                                      # what an option does, in brackets
    |,?(?:\ (?:as|as\ in|with))?\ --[a-z][a-z-]*(?:\ [\w.]+=(?:'[^']*'|[^\s;,)]+)|\ [\w.-]*\d[\w.-]*)?""",
    re.VERBOSE,
)
"""What a message says to who types commands."""


def on_the_page(words: str) -> str:
    """Leave out of a message the options and commands that nobody can type on the page."""
    return OPTION.sub("", words)
