"""Recordings of other boards, from the files people have."""

from daq.importing.errors import ImportProblem as ImportProblem
from daq.importing.options import ImportOptions as ImportOptions
from daq.importing.reading import read_file as read_file, read_runs as read_runs
from daq.importing.recipe import Recipe as Recipe, read_recipe as read_recipe
