"""Recipes for recordings whose files do not say all, one a logger."""

from pathlib import Path

from daq.importing.recipe import Recipe, read_recipe

OF = {
    **{f"labelled/pendulum_in_{where}.csv": "pendulum_in_fluid" for where in ("air", "water")},
    "labelled/tower_alone.txt": "tower",
    "labelled/tower_pendulum_free.txt": "tower",
    "labelled/tower_pendulum_locked.txt": "tower",
    "labelled/water_gauge_with_damper.txt": "water_gauge",
    "labelled/water_gauge_without_damper.txt": "water_gauge",
    "rigs/friction_damper_forced.json": "friction_damper",
    **{f"rigs/pendulum_encoder_{i}.txt": "pendulum_encoder" for i in (1, 2, 3)},
}


def recipe_of(name: str) -> Recipe | None:
    """Return the recipe of a recording, by its name in the folder of recordings; None where none is needed."""
    return read_recipe(Path(__file__).parent / f"{OF[name]}.toml") if name in OF else None
