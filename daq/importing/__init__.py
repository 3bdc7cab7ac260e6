"""Recordings of other boards, from the files people have."""

from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from daq.importing.reading import read_file, read_runs

__all__ = ["ImportOptions", "ImportProblem", "read_file", "read_runs"]
