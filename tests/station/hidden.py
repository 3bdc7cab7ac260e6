"""Releases with a hidden effect and their truth, made by a program that is not part of the project."""

import json
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent / "data" / "hidden"
TRUTH = {entry["file"]: entry for entry in json.loads((FOLDER / "truth.json").read_text(encoding="utf-8"))}
DUFFING, DRIFT = (FOLDER / f"release_{number}.csv" for number in ("14", "07"))
NOTHING = FOLDER.parent / "release_24.csv"
