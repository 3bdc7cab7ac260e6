"""The working folder may be a stranger's: no module is imported from it and no library's settings are read there.

What is read of it is what the operator names, and `station.toml`. Python itself would import from it in every process
that it starts (a worker of a campaign or of the page, the simulated board), and an editable installation adds a name
without a folder to the path of modules, which is looked for there. matplotlib would read `matplotlibrc`, and numba
`.numba_config.yaml` (see `identify.compilation`). `python -m station` imports from it before this program has a say.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def import_nothing_from_it() -> None:
    """Take the working folder off the path of modules, in this process and in those that it starts."""
    own = str(Path(__file__).parent.parent)
    if sys.path and sys.path[0] != own and _is_working_folder(sys.path[0]):
        del sys.path[0]
    sys.path[:] = [place for place in sys.path if os.path.isabs(place)]
    os.environ["PYTHONSAFEPATH"] = "1"


def _is_working_folder(place: str) -> bool:
    try:
        return os.path.samefile(place, os.curdir)
    except OSError:
        return False


@contextmanager
def unseen(name: str) -> Iterator[None]:
    """Import a library that would read settings of that name in the working folder as if there were none."""
    real = os.path.exists
    vars(os.path)["exists"] = lambda path: path != name and real(path)
    try:
        yield
    finally:
        vars(os.path)["exists"] = real
