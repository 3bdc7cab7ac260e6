"""Read a file of any known format: one importer a format, chosen by what the file is."""

from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote

from daq.importing.apply import apply
from daq.importing.csv_text import read_csv
from daq.importing.errors import MAX_BYTES, problem, require_size
from daq.importing.json_text import is_json, read_json
from daq.importing.matlab import is_matlab, read_matlab
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful, Proposal, propose
from daq.importing.recipe import Recipe
from daq.importing.stamps import NoClock
from daq.importing.table import Table
from daq.importing.uff58 import is_uff, read_uff
from daq.recording import Recording


def read_file(path: str | Path, options: ImportOptions | None = None) -> Recording:
    """Return the recording in a file of another board: text table, JSON, MATLAB v5 or UFF58.

    What was understood and what was guessed stands in the recording's notes. Raises ImportProblem, one
    sentence with file, line and column where there are any, also when the file holds several runs and none is named.
    """
    found = read_runs(path, options)
    if len(found) > 1:
        names = ", ".join(recording.run for recording in found)
        raise problem(
            Path(path), f"holds {len(found)} runs ({names})",
            f"name one, as in --run {quote(found[0].run)}, or in Python read_recordings(...)",
        )  # fmt: skip
    return found[0]


def read_runs(
    path: str | Path, options: ImportOptions | None = None, recipe: Recipe | None = None
) -> tuple[Recording, ...]:
    """Return the recordings in a file, one for each run in it, in the order of the file; usually there is one.

    With a `recipe` the file is read by it alone. A run that cannot be read is left out, and the notes of the others say why.
    Raises ImportProblem as `read_file`, and when no run can be read.
    """
    options = options or ImportOptions()
    return look_at(path, options, recipe).read(accept=options.accept).recordings


@dataclass(frozen=True, eq=False)
class Read:
    """The recordings in a file, and the recipe that made them."""

    recipe: Recipe
    recordings: tuple[Recording, ...]


@dataclass(frozen=True, eq=False)
class Look:
    """A file as a table, and a recipe for it: the one given, or a proposal."""

    table: Table
    proposal: Proposal

    def read(self, *, accept: bool = False) -> Read:
        """Return the recordings. Raises Doubtful, with a recipe, where something is to be said or confirmed before."""
        proposal, settled = self.proposal, True
        made: tuple[Recording, ...] = ()
        more: tuple[str, ...] = ()
        try:
            made = apply(self.table, proposal.recipe)
        except NoClock as refusal:
            recipe = proposal.recipe.model_copy(update=dict(refusal.remedy))
            settled = recipe != proposal.recipe
            if not settled and (accept or refusal.remedy):
                raise
            doubt = () if refusal.done else (str(refusal).removeprefix(self.table.path.name).lstrip(",: "),)
            proposal = replace(proposal, recipe=recipe, doubts=(*proposal.doubts, *doubt))
            more = (refusal.done,) if refusal.done else ()
            made = apply(self.table, recipe) if settled else ()
        if proposal.doubts and not accept:
            sentence = f"{self.table.path.name}: {'; and '.join(proposal.doubts)}"
            raise Doubtful(sentence, proposal, settled=settled)
        cut = len(proposal.recipe.parts) > 1
        runs = [one.run.rpartition(".")[0] if cut else one.run for one in made]
        told = [proposal.notes.get(run, proposal.notes.get("", ())) for run in runs]
        noted = [replace(one, notes=(*one.notes, *own, *more)) for one, own in zip(made, told, strict=True)]
        return Read(proposal.recipe, tuple(noted))


def look_at(path: str | Path, options: ImportOptions | None = None, recipe: Recipe | None = None) -> Look:
    """Return a file as a table, with a recipe for it. Raises ImportProblem where it cannot be read at all."""
    options = options or ImportOptions()
    table = read_table(Path(path), recipe or options.as_recipe())
    return Look(table, propose(table, options) if recipe is None else Proposal(recipe, {}))


def read_table(path: Path, recipe: Recipe) -> Table:
    """Return the columns of a file, as the recipe says that it is written, else as is found out."""
    data = _bytes(path)
    if is_matlab(data):
        return read_matlab(path, data, recipe)
    if is_uff(data):
        return read_uff(path, data, recipe)
    if is_json(data):
        return read_json(path, data, recipe)
    return read_csv(path, data, recipe)


def _bytes(path: Path) -> bytes:
    """Return the contents of a file. Raises ImportProblem when there is none, or it is not a plain file."""
    try:
        if path.is_dir():
            raise problem(path, "is a folder", "name a file in it")
        if not path.is_file():
            there = path.exists()
            raise problem(
                path, "is not a plain file" if there else "does not exist", "name a file with a recording"
            )
        require_size(path, path.stat().st_size, MAX_BYTES)
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise problem(path, f"cannot be read ({reason})", "check the name and the permissions") from None
    if not data.strip(b"\0 \t\r\n"):
        raise problem(path, "is empty", "record again or name another file")
    return data
