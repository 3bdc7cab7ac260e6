"""What libraries say on the way is one line that commands no terminal."""

import logging
import subprocess
import sys

from station.output import OneLine

WARNS = """
import logging, warnings
from station import cli
from station.text import layout

def warn(*_, **__):
    warnings.warn("overflow encountered in exp", RuntimeWarning, stacklevel=1)
    warnings.warn("column \\x1b[2Jname\\nverdict: OK is odd", stacklevel=1)
    try:
        raise TimeoutError("JavaScript did not respond within 5.0 s")
    except TimeoutError as error:
        logging.getLogger("nicegui").exception(error)

layout.print_json = warn
cli.main(["list", "--json"])
"""


def test_a_librarys_warning_forges_no_line_shows_no_path_and_commands_no_terminal(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", WARNS], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stderr.splitlines() == [
        "UserWarning: column \N{REPLACEMENT CHARACTER}[2Jname verdict: OK is odd",
        "nicegui: TimeoutError: JavaScript did not respond within 5.0 s",
    ]


def test_what_a_library_logs_is_one_line_without_a_traceback():
    said = []
    logger = logging.Logger("nicegui")
    logger.addHandler(OneLine(said.append))
    try:
        raise TimeoutError("JavaScript did not respond\nwithin 5.0 s")
    except TimeoutError as error:
        logger.exception(error)
    assert said == ["nicegui: TimeoutError: JavaScript did not respond within 5.0 s"]
