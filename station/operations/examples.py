"""The examples: recordings that come with the station, for whoever has no board."""

from dataclasses import dataclass, field
from pathlib import Path

from daq.importing.options import ImportOptions
from daq.session import Session
from daq.session_info import SessionInfo
from station.exits import UsageProblem
from station.suggestions import did_you_mean

PLACES = ("examples", "share/free-decay-station/examples")
"""Where the recordings lie, from a folder above this file: in a clone, and where a wheel puts them."""


@dataclass(frozen=True)
class Example:
    """One recording: its name, its file in the folder of examples, what it is, and what its import needs."""

    name: str
    file: str
    about: str
    mass_kg: float | None = None
    options: ImportOptions = field(default_factory=ImportOptions)


TESTBED_KG = 21.36
SILVERBOX = ImportOptions(
    columns={"force": "V1", "displacement": "V2"}, units={"force": "V", "displacement": "V"}, rate=610.35
)
EXAMPLES = (
    Example("simulated_plain", "simulated_plain.csv", "simulated testbed, nothing hidden", TESTBED_KG),
    Example("simulated_stribeck", "simulated_stribeck.csv", "simulated, one force hidden", TESTBED_KG),
    Example("simulated_drift", "simulated_drift.csv", "simulated, one sensor at fault", TESTBED_KG),
    Example("ship_roll", "ship_roll.csv", "roll decay of a ship model, measured"),
    Example("spring_disc", "spring_disc.csv", "disc on a spring in air, measured by sonar", 0.2016),
    Example("silverbox", "silverbox.mat", "electronic hardening spring, driven", None, SILVERBOX),
)


def examples_folder() -> Path:
    """Return the folder that holds the recordings: that of the clone, else the one that was installed.

    It is looked for upwards from here, so that it is found in an environment, in a user's folder (`pip install --user`)
    and in any other (`--target`).
    """
    above = Path(__file__).resolve().parents
    for folder in (parent / place for parent in above for place in PLACES):
        if (folder / EXAMPLES[0].file).is_file():
            return folder
    raise UsageProblem(f"the examples were not installed (looked in {' and '.join(PLACES)} above {above[0]})")


def open_example(name: str, sessions: Path) -> Session:
    """Return the session of an example; it is imported into `sessions` the first time. UsageProblem when there is none."""
    wanted = next((one for one in EXAMPLES if one.name == name), None)
    if wanted is None:
        names = [one.name for one in EXAMPLES]
        meant = did_you_mean(name, names) or f"; there are {', '.join(names)}"
        raise UsageProblem(f"there is no example '{name}'{meant}")
    folder = sessions / name
    if folder.is_dir():
        return Session.open(folder)
    from station.results.sessions import import_file  # not before a typo is answered: it loads the numerics

    info = SessionInfo(specimen=wanted.about, mass_kg=wanted.mass_kg)
    file = examples_folder() / wanted.file
    return import_file(file, folder, sessions, wanted.options, info).sessions[0]
