"""Recordings of other boards, from the files people have."""

from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from daq.importing.reading import read_file, read_runs
from daq.importing.recipe import Recipe, read_recipe

__all__ = ["ImportOptions", "ImportProblem", "Recipe", "read_file", "read_recipe", "read_runs"]
