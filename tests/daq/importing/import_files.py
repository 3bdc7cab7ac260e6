"""Small files for the importers' tests, from closed forms."""

from pathlib import Path

import numpy as np
import pytest

from daq.importing import ImportOptions, ImportProblem, read_file
from daq.importing.reading import look_at
from daq.importing.recipe import Recipe, read_recipe, to_toml
from daq.recording import Array, Recording

RATE = 100.0
OMEGA = 2 * np.pi * 1.3


def swing(n: int = 200, rate: float = RATE, damping: float = 0.1) -> tuple[Array, Array, Array, Array]:
    """Return time, displacement, velocity, acceleration of u = 0.02 exp(-damping t) cos(OMEGA t)."""
    t = np.arange(n) / rate
    pole = complex(-damping, OMEGA)
    motion = 0.02 * np.exp(pole * t)
    return t, motion.real, (pole * motion).real, (pole**2 * motion).real


def write(folder: Path, text: str | bytes, name: str = "a.csv") -> Path:
    """Write a file and return its path."""
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def table(header: str, *columns: Array, delimiter: str = ",", form: str = "%.9g", comma: bool = False) -> str:
    """Return a text table; `comma` makes the decimal sign a comma."""
    rows = [delimiter.join(form % value for value in row) for row in zip(*columns, strict=True)]
    text = "\n".join(rows)
    return f"{header}\n{text.replace('.', ',') if comma else text}\n" if header else text + "\n"


def load(folder: Path, text: str | bytes, name: str = "a.csv", **options: object) -> Recording:
    """Write a file and import it; the recipe that was used, written and read again, must make the same of it."""
    path, wanted = write(folder, text, name), ImportOptions(**options)  # type: ignore[arg-type]
    recording = read_file(path, wanted)
    used = look_at(path, wanted).read(accept=wanted.accept).recipe
    (again,) = look_at(path, recipe=kept(folder, used)).read().recordings
    assert (again.rate, again.gaps, again.run) == (recording.rate, recording.gaps, recording.run)
    assert [(c.quantity, c.unit) for c in again.channels] == [
        (c.quantity, c.unit) for c in recording.channels
    ]
    np.testing.assert_array_equal(again.samples, recording.samples)
    np.testing.assert_array_equal(again.valid, recording.valid)
    return recording


def kept(folder: Path, recipe: Recipe) -> Recipe:
    """Write a recipe as an import does, and read it again."""
    file = folder / "recipe.toml"
    file.write_bytes(to_toml(recipe).encode())
    return read_recipe(file)


def refusal(folder: Path, text: str | bytes, name: str = "a.csv", **options: object) -> str:
    """Return the sentence with which a file is refused."""
    with pytest.raises(ImportProblem) as caught:
        load(folder, text, name, **options)
    assert caught.value.exit_code == 2
    message = str(caught.value)
    assert message.startswith(name)
    assert "\n" not in message
    return message


def said(recording: Recording) -> str:
    """Return the notes of a recording as one text."""
    return "\n".join(recording.notes)
