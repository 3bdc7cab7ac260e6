"""The sections of the loop: the suspects, the ladder, and what could not be told apart."""

from typing import Any

from station.report import diagnosis_figures as draw
from station.report.content import Figure, Part, Section, Table, Words, left_out
from station.report.findings import Findings
from station.report.numbers import prose, symbol, three, with_unit
from station.text.diagnosis_text import evidence, headline, indistinguishable, probability, shown_suspects
from station.text.ladder_text import change, step

SUSPECTS = "Suspects: which effect is missing"
LADDER = "The ladder: the error, rung by rung"
APART = "What could not be told apart, and the next recording"


def suspects(found: Findings) -> Section:
    """Show the verdict of the diagnosis, the suspects in order, and their fingerprints."""
    document = found.diagnosis
    if document is None:
        return Section("suspects", SUSPECTS, (left_out(found.left_out["suspects"]),))
    parts: list[Part] = [Words(prose(document["explanation"]), label=headline(document), strong=True)]
    if len(document["sessions"]) > 1:
        parts.append(Words(", ".join(map(str, document["sessions"])), label="Diagnosed together"))
    if document["suspects"]:
        rows = tuple(
            (
                suspect["effect"],
                suspect["title"],
                three(suspect["error_after"]),
                evidence(suspect["evidence"]),
                probability(suspect["p_value"]),
                _parameters(suspect),
            )
            for suspect in shown_suspects(document)
        )
        head = ("effect", "what it is", "chi² with it", "evidence (nats)", "p by chance", "parameters")
        parts.append(Table("Suspects in order", head, rows, texts=2, wordy=True))
        picture = draw.errors(document)
        if picture is not None:
            parts.append(
                Figure("What is left after adding each suspect to the model that was diagnosed.", picture)
            )
    if found.suspects is not None and found.suspects.best:
        caption = (
            "Fingerprints: the force that the model lacks over the cycle (0°: farthest out), and what the best "
            "suspects would add. The right one looks like the first picture."
        )
        parts.append(Figure(caption, draw.fingerprints(found.suspects)))
    elif "fingerprints" in found.left_out:
        parts.append(Words(f"The fingerprints are left out: {found.left_out['fingerprints']}."))
    parts += _findings(document)
    return Section("suspects", SUSPECTS, tuple(parts))


def _parameters(suspect: dict[str, Any]) -> str:
    values = [f"{symbol(name)} = {with_unit(value)}" for name, value in suspect["parameters"].items()]
    where = [f"in the {suspect['channel']}"] if suspect["channel"] else []
    return "; ".join([*where, *values])


def _findings(document: dict[str, Any]) -> list[Part]:
    parts: list[Part] = []
    for finding in document["findings"]:
        text = f"{finding['title']} ({_parameters(finding)}); {finding['what_to_do']}."
        parts.append(Words(text, label="Sensor"))
    shape = document["shape"]
    if shape is not None and shape["curves"]:
        caption = (
            f"The free form of what has no name; it explains {100 * shape['explained']:.0f} % of the rest."
        )
        parts.append(Figure(caption, draw.shape(shape["curves"][0])))
    return parts


def ladder(found: Findings) -> Section:
    """Show the errors from the usual model to the present one, and the floor."""
    if found.climb is None:
        return Section("ladder", LADDER, (left_out(found.left_out["ladder"]),))
    kept = found.climb.ladder
    rows: list[tuple[str, ...]] = []
    for place, rung in enumerate(kept.rungs[: kept.present + 1]):
        before = kept.rungs[place - 1].error.chi2 if place else None
        error = rung.error
        rows.append(
            (
                str(place), step(rung), three(error.force_mse_percent), three(error.motion_percent),
                three(error.chi2), change(before, error.chi2) if place else "",
            )
        )  # fmt: skip
    floor = kept.floor
    rows.append(
        ("", "noise alone", three(floor.force_mse_percent), three(floor.motion_percent),
         f"1 ± {kept.top.chi2_std:.2f}", "")
    )  # fmt: skip
    head = ("rung", "effect", "force MSE [%]", "motion [%]", "chi²", "change of chi²")
    parts: list[Part] = [Table("The ladder", head, tuple(rows), texts=2)]
    picture = draw.rungs(kept)
    if picture is not None:
        parts.append(Figure("chi² rung by rung (band: two standard errors of the floor).", picture))
    if kept.stopped_because:
        reason = kept.stopped_because
        parts.append(Words(f"{reason[0].upper()}{reason[1:]}."))
    return Section("ladder", LADDER, tuple(parts))


def apart(found: Findings) -> Section:
    """Say what this record cannot tell apart or determine, and what to record next."""
    parts: list[Part] = []
    document = found.diagnosis
    if document is not None:
        rivals = indistinguishable(document)
        if rivals:
            parts.append(Words(f"{document['named'][0]} from {', '.join(rivals)}.", label="Not told apart"))
        elif document["named"]:
            parts.append(
                Words(
                    "every other suspect leaves clearly more than the one that was named.", label="Told apart"
                )
            )
        known = (
            document["suspects"][0]["confusable_with"] if document["named"] and document["suspects"] else []
        )
        if known:
            parts.append(
                Words(
                    f"{', '.join(known)}; a record of another kind separates them.", label="Easily confused"
                )
            )
        parts.append(Words(prose(document["next_experiment"]), label="Record next", strong=True))
    else:
        parts.append(
            Words("No diagnosis was made, and so nothing is said about what else would explain this record.")
        )
    compared = found.climb.compared if found.climb is not None else found.compared
    if compared is not None and compared.start.fit.unidentifiable:
        names = ", ".join(compared.start.fit.unidentifiable)
        parts.append(Words(names, label="Not determined by this record"))
    return Section("apart", APART, tuple(parts))
