"""The formats, by name and by the ending of a file."""

import importlib
from collections.abc import Callable
from pathlib import Path

from daq.errors import OperatorError
from daq.exporting.exported import Exported

FORMATS = {
    "csv": (".csv", "daq.exporting.csv_table"),
    "mat": (".mat", "daq.exporting.matlab"),
    "uff": (".uff", "daq.exporting.universal_file"),
    "hdf5": (".h5", "daq.exporting.hdf5"),
    "parquet": (".parquet", "daq.exporting.parquet"),
    "mcap": (".mcap", "daq.exporting.mcap_log"),
}
"""Ending and module of each format."""

_MORE_ENDINGS = {".hdf5": "hdf5", ".unv": "uff", ".txt": "csv"}


def form_of(file: Path) -> str | None:
    """Return the format that the ending of a file's name stands for; None where it stands for none."""
    ending = file.suffix.lower()
    by_ending = {its: name for name, (its, _) in FORMATS.items()} | _MORE_ENDINGS
    return by_ending.get(ending)


def encode(exported: Exported, form: str) -> bytes:
    """Return a file's content in one of FORMATS. Raises OperatorError where the format's library is not installed."""
    try:
        module = importlib.import_module(FORMATS[form][1])
    except ModuleNotFoundError as missing:
        raise OperatorError(
            f"the format {form} needs the package {missing.name}, which is not installed; "
            "install it with: pip install 'free-decay-station[export]'"
        ) from missing
    write: Callable[[Exported], bytes] = module.encode
    return write(exported)
