"""A diagnosis in one screenful of 80 columns: the verdict first, then why, the suspects, what to record next."""

import math
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from station.quantities import with_error

VERDICTS = {
    "missing_effect": "A FORCE IS MISSING",
    "sensor_fault": "A SENSOR IS AT FAULT",
    "nothing_missing": "NOTHING IS MISSING",
    "unknown_effect": "SOMETHING IS MISSING THAT HAS NO NAME HERE",
    "not_enough_data": "NOT ENOUGH DATA",
}
STYLES = {"nothing_missing": "bold green", "not_enough_data": "bold yellow"}
MOST_SUSPECTS = 6
CLAIMED = 0.02
TOLD_APART = 4.6


def headline(document: dict[str, Any]) -> str:
    """Return the verdict in one line."""
    words = VERDICTS[document["verdict"]]
    return f"{words}: {' and '.join(document['named'])}" if document["named"] else words


def show_diagnosis(console: Console, document: dict[str, Any]) -> None:
    """Print a diagnosis."""
    verdict = document["verdict"]
    console.print()
    console.print(Text(f" {headline(document)}", style=STYLES.get(verdict, "bold red")))
    console.print()
    console.print(Padding(Text(document["explanation"]), (0, 1)))
    if document["suspects"]:
        console.print()
        console.print(Padding(_errors(document), (0, 0, 0, 1)))
        console.print()
        console.print(Padding(_suspects(document), (0, 0, 0, 1)))
    console.print()
    for label, text in _facts(document):
        line = Table.grid(padding=(0, 1))
        line.add_column(width=12)
        line.add_column(overflow="fold")
        line.add_row(Text(f" {label}", style="cyan"), Text(text))
        console.print(line)
    console.print()


def _errors(document: dict[str, Any]) -> Text:
    error, floor = document["error"], document["noise_floor"]
    return Text(
        f"model: {' + '.join(document['model']['effects'])}\n"
        f"leaves {size(error['force_mse_percent'])} % of the force, {size(error['motion_percent'])} % of the motion "
        f"over {error['horizon_s']:.1f} s,\n"
        f"and {size(error['chi2'])} times what noise explains (chi2; floor 1.00 ± {floor['chi2_std']:.2f})"
    )


def _suspects(document: dict[str, Any]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("suspect", no_wrap=True)
    table.add_column("chi2\nafter", justify="right")
    table.add_column("evidence", justify="right", no_wrap=True)
    table.add_column("p", justify="right", no_wrap=True)
    table.add_column("with", overflow="fold")
    for rank, suspect in enumerate(shown_suspects(document)):
        style = "" if is_claimed(suspect) else "dim"
        table.add_row(
            Text(suspect["effect"], style=style),
            Text(size(suspect["error_after"]), style=style),
            Text(evidence(suspect["evidence"]), style=style),
            Text(probability(suspect["p_value"]), style=style),
            Text(_parameters(suspect, None if rank == 0 else 1), style=style),
        )
    return table


def shown_suspects(document: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the suspects that are worth a line: all that chance would hardly give, at least three, and what is as good."""
    suspects: list[dict[str, Any]] = document["suspects"]
    claimed = [s for s in suspects if is_claimed(s)]
    rivals = indistinguishable(document)
    most = max(3, min(MOST_SUSPECTS, len(claimed)))
    return [s for rank, s in enumerate(suspects) if rank < most or s["effect"] in rivals]


def is_claimed(suspect: dict[str, Any]) -> bool:
    """Return whether chance would hardly give as good a reason."""
    p: float | None = suspect["p_value"]
    return p is not None and p < CLAIMED


def evidence(nats: float | None) -> str:
    """Return evidence in words and in nats: how much better than chance."""
    if nats is None or not math.isfinite(nats):
        return "none"
    words = next(
        (word for limit, word in ((100, "decisive"), (12, "strong"), (TOLD_APART, "some")) if nats >= limit),
        "none",
    )
    return f"{words} {nats:.0f}" if abs(nats) < 1e4 else f"{words} {nats:.1e}".replace("e+0", "e")


def probability(p: float | None) -> str:
    """Return a probability as people read it."""
    if p is None or not math.isfinite(p):
        return "-"
    return "<1e-6" if p < 1e-6 else f"{p:.0e}".replace("e-0", "e-") if p < 0.01 else f"{p:.2f}"


def size(value: float | None) -> str:
    """Return an error with three figures."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{value:.0f}" if value >= 100 else f"{value:#.3g}"


def _parameters(suspect: dict[str, Any], most: int | None) -> str:
    parts = [f"{name} {number(value)}" for name, value in list(suspect["parameters"].items())[:most]]
    where = f"in the {suspect['channel']}" if suspect["channel"] else ""
    return "; ".join([*([where] if where else []), *parts])


def number(value: dict[str, Any]) -> str:
    """Return a value with its error and its unit."""
    unit = "" if value["unit"] == "1" else f" {value['unit']}"
    std = value["std"]
    if std is None or not math.isfinite(std):
        return f"{value['value']:.4g}{unit}"
    if abs(value["value"]) >= 1e4:
        return f"{value['value']:.4g} ± {std:.1g}{unit}"
    return f"{with_error(value['value'], std)}{unit}"


def _facts(document: dict[str, Any]) -> list[tuple[str, str]]:
    facts = []
    rivals = indistinguishable(document)
    if rivals:
        facts.append(
            ("the same", f"this record does not tell {document['named'][0]} from {', '.join(rivals)}")
        )
    for finding in document["findings"]:
        where = f" in the {finding['channel']}" if finding["channel"] else ""
        values = ", ".join(f"{name} {number(value)}" for name, value in finding["parameters"].items())
        facts.append(("sensor", f"{finding['title']}{where} ({values}); {finding['what_to_do']}"))
    if document["shape"] is not None and document["shape"]["coordinates"]:
        shape = document["shape"]
        along = " and ".join(shape["coordinates"])
        facts.append(
            ("shape", f"a free-form force over {along} explains {100 * shape['explained']:.0f} % of the rest")
        )
    if document["held_out"]:
        parts = [f"{one['session']} {_left(one['chi2'])}" for one in document["held_out"]]
        facts.append(("left out", f"physics of the others on each session, chi2: {', '.join(parts)}"))
    facts.append(("record next", document["next_experiment"]))
    return facts


def _left(chi_square: float | None) -> str:
    return size(chi_square) if chi_square is not None and math.isfinite(chi_square) else "runs away"


def indistinguishable(document: dict[str, Any]) -> list[str]:
    """Return the suspects that explain the record as well as the first one."""
    if not document["named"] or not document["suspects"]:
        return []
    first, *others = document["suspects"]
    return [
        other["effect"]
        for other in others
        if is_claimed(other) and abs((first["evidence"] or 0.0) - (other["evidence"] or 0.0)) < TOLD_APART
    ]
