"""The command that imports a file of which something is to be confirmed, by the recipe that is proposed."""

from pathlib import Path

from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful
from daq.importing.recipe import to_toml
from station.exits import UsageProblem
from station.output import command_line


def explained(file: Path, options: ImportOptions, refusal: ImportProblem) -> UsageProblem | ImportProblem:
    """Return a refusal with the command to type, where a recipe is proposed that would do."""
    if not isinstance(refusal, Doubtful):
        return refusal
    words = [word for option in _given(options) for word in option]
    proposal = refusal.proposal
    asked = [] if refusal.settled else ["--rate", "HZ"]
    command = command_line("import", file, *words, *asked)
    how = "as proposed" if refusal.settled else "as proposed, with its rate in place of HZ"
    said = {"doubts": list(proposal.doubts), "recipe": to_toml(proposal.recipe)}
    where = "These are options of `station import`, and --ask opens the recipe there"
    return UsageProblem(f"{refusal}. {where}. To read it {how}, type: {command}", **said)


def _given(options: ImportOptions) -> list[list[str]]:
    given = [["--column", f"{quantity}={column}"] for quantity, column in options.columns.items()]
    given += [["--unit", f"{quantity}={unit}"] for quantity, unit in options.units.items()]
    values = {
        "--rate": options.rate, "--run": options.run, "--from": options.start, "--to": options.stop,
        "--delimiter": {"\t": "tab", " ": "blank"}.get(options.delimiter or "", options.delimiter),
        "--decimal": options.decimal, "--encoding": options.encoding, "--skip-rows": options.skip_rows or None,
        "--angle-from": None if options.angle_from is None else ",".join(options.angle_from),
    }  # fmt: skip
    given += [
        [name, f"{v:g}" if isinstance(v, float) else str(v)] for name, v in values.items() if v is not None
    ]
    flags = {
        "--resample": options.resample,
        "--keep-derived": options.keep_derived,
        "--keep-offset": options.keep_offset,
        "--accept": True,
    }
    return given + [[name] for name, wanted in flags.items() if wanted]
