"""Universal files, data set 58: one trace a set, its quantity by the set's own codes, through pyuff."""

import re
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from daq.importing.errors import ImportProblem, problem, require_few
from daq.importing.recipe import Recipe
from daq.importing.table import SourceColumn, Table, common_length
from daq.importing.units import SI_ANGULAR, SI_LINEAR

TIME_RESPONSES = (0, 1)
QUANTITY_CODES = {8: "displacement", 11: "velocity", 12: "acceleration", 9: "force", 13: "force"}
DIRECTIONS = {0: "", 1: "+X", 2: "+Y", 3: "+Z", 4: "+RX", 5: "+RY", 6: "+RZ"}
DIRECTIONS |= {-k: text.replace("+", "-") for k, text in DIRECTIONS.items() if k}
MAX_TRACES = 2000
NO_TEXT = ("", "none", "null")


def is_uff(data: bytes) -> bool:
    """Check whether these bytes begin a universal file: a line `-1`, then the number of a data set."""
    return re.match(rb"(?:\s*-1[ \t]*\r?\n)+\s*\d{1,5}[bB \t\r\n]", data[:400]) is not None


def read_uff(path: Path, data: bytes, recipe: Recipe) -> Table:
    """Return the time traces of a universal file as columns. Raises ImportProblem."""
    sets, kinds = _sets(path, data)
    traces = [(n, t) for n, t in sets if int(t.get("func_type", -1)) in TIME_RESPONSES]
    traces = [(n, t) for n, t in traces if np.size(t.get("data", ())) > 1 and not np.iscomplexobj(t["data"])]
    traces = [(n, t) for n, t in traces if np.size(t.get("x", ())) == np.size(t["data"])]
    if not traces:
        found = ", ".join(str(k) for k in kinds[:8]) or "none"
        raise problem(
            path, f"holds no time trace of data set 58 (data sets found: {found})",
            "export the time responses (function type 1), not spectra",
        )  # fmt: skip
    notes = [f"universal file: {len(traces)} time traces in {len(kinds)} data sets"]
    if len(traces) < len(sets):
        notes.append(f"{len(sets) - len(traces)} data sets 58 are no real time responses and were left out")
    sizes = [((str(n), _label(t)), int(np.size(t["data"]))) for n, t in traces]
    length = common_length(path, recipe, sizes)
    first, stamps = next((n, np.ravel(t["x"])) for n, t in traces if np.size(t["data"]) == length)
    columns = []
    for number, trace in traces:
        if not np.array_equal(stamps, np.ravel(trace["x"])):
            notes.append(f"data set {number} has other times than data set {first}, and was left out")
            continue
        quantity, unit = _quantity(trace)
        values = np.ravel(trace["data"])
        columns.append(SourceColumn(number, _label(trace), values, unit, quantity, noun="data set"))
    columns.append(SourceColumn(columns[-1].number + 1, "time", stamps, "s", "time", noun="abscissa"))
    return Table(path, tuple(columns), None, None, "", tuple(notes), format="uff")


def _sets(path: Path, data: bytes) -> tuple[list[tuple[int, dict[str, Any]]], list[int]]:
    """Return the data sets 58 with their numbers, and the types of all sets, after a look at what the headers promise."""
    import pyuff

    try:
        with warnings.catch_warnings(), tempfile.TemporaryDirectory() as folder:
            warnings.simplefilter("ignore")
            copy = Path(folder) / "traces.uff"
            # A binary set written over another leaves the end mark of the lost one in front.
            copy.write_bytes(re.sub(rb"^\s*-1[ \t]*\r?\n(?=\s*-1[ \t]*\r?\n)", b"", data, count=1))
            file = pyuff.UFF(str(copy))
            kinds = [int(k) for k in file.get_set_types()]
            require_few(path, len(kinds), MAX_TRACES, "data sets", "export one recording")
            sets = []
            for i, kind in enumerate(kinds):
                if kind != 58:
                    continue
                promised = int(file.read_sets(i, header_only=True).get("num_pts", 0))
                if not 0 <= promised <= len(data):
                    raise problem(
                        path,
                        f"data set {i + 1} promises {promised} samples, more than the file can hold",
                        "export it again",
                    )
                sets.append((i + 1, dict(file.read_sets(i))))
            return sets, kinds
    except ImportProblem:
        raise
    except Exception as error:
        said = " ".join(str(error).split())[:80] or type(error).__name__
        raise problem(path, f"is a damaged universal file ({said})", "export it again") from None


def _quantity(trace: dict[str, Any]) -> tuple[str | None, str]:
    """Return the quantity that the ordinate's code says and its unit; SI by the standard where no unit is written."""
    quantity = QUANTITY_CODES.get(int(trace.get("ordinate_spec_data_type", 0)))
    unit = str(trace.get("ordinate_axis_units_lab", "")).strip()
    if unit.lower() in NO_TEXT:
        rotation = abs(int(trace.get("rsp_dir", 0))) > 3
        unit = (SI_ANGULAR if rotation else SI_LINEAR)[quantity].si if quantity else ""
    return quantity, unit


def _label(trace: dict[str, Any]) -> str:
    """Return the trace's name: its axis label or ID line, with node and direction."""
    texts = (str(trace.get(key, "")).strip() for key in ("ordinate_axis_lab", "id1", "id5"))
    name = next((text for text in texts if text.lower() not in NO_TEXT), "")
    direction = DIRECTIONS.get(int(trace.get("rsp_dir", 0)), "")
    node = int(trace.get("rsp_node", 0))
    place = f"{node}:{direction}" if direction or node else ""
    return f"{name} {place}".strip()
