"""The command that imports a file of which something is to be confirmed, by the recipe that is proposed."""

from collections.abc import Sequence
from pathlib import Path

from daq.importing.errors import ImportProblem
from daq.importing.propose import Doubtful
from daq.importing.recipe import to_toml
from station.exits import UsageProblem
from station.output import command_line


def explained(refusal: ImportProblem, typed: Sequence[str | Path]) -> UsageProblem | ImportProblem:
    """Return a refusal with the command to type, where a recipe is proposed that would do.

    `typed` are the words of the command that imports the file.
    """
    if not isinstance(refusal, Doubtful):
        return refusal
    proposal = refusal.proposal
    asked = [] if refusal.settled else ["--rate", "HZ"]
    command = command_line(*typed, "--accept", *asked)
    how = "as proposed" if refusal.settled else "as proposed, with its rate in place of HZ"
    said = {"doubts": list(proposal.doubts), "recipe": to_toml(proposal.recipe)}
    where = "These are options of `station import`, and --ask opens the recipe there"
    return UsageProblem(f"{refusal}. {where}. To read it {how}, type: {command}", **said)
