"""The sections on the record: set-up with calibration and verdict, and the software that was used."""

import platform
from datetime import UTC

from daq.recording import Channel
from identify.formatting import three_figures
from station.report.findings import Findings
from station.report.first_page import NOT_STATED
from station.settings import version_of
from station.text.content import Facts, Figure, Paragraph, Part, Table, facts, left_out
from station.text.identification_text import flagged_lines, sampling
from station.text.numbers import typeset_unit
from station.views.identification_figures import record

PACKAGES = ("free-decay-station", "numpy", "scipy", "numba", "matplotlib")


def setup(found: Findings) -> list[Part]:
    """Show the record: the verdict on it, from where it is, how it was sampled, with which sensors and calibrations."""
    info, recording, board = found.session.info, found.recording, found.session.info.board
    result = found.identification
    flags = found.manifest.flags if found.manifest is not None else ()
    sampled = sampling(recording.samples.shape[1], recording.rate, recording.rate_std)
    rows = [
        ("recorded" if board else "imported", info.created.astimezone(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")),
        ("source", info.source_file or info.source or NOT_STATED),
        ("board", f"{board.board}, firmware {board.firmware}, identity {board.unique_id}" if board else ""),
        ("sampling", f"{sampled}, {int((~recording.valid).sum())} lost, marked and never filled in"),
        ("flagged", "; ".join(flagged_lines([flag.model_dump() for flag in flags], recording.rate))),
        ("how it was read", "; ".join(recording.notes)),
        ("remarks", info.remarks),
    ]
    table = Table(
        "Channels and their calibration",
        ("channel", "quantity", "unit", "sensor", "calibrated", "uncertainty", "resolution", "range"),
        tuple(_channel(found, channel) for channel in recording.channels),
        texts=5,
    )
    parts: list[Part] = [_verdict(found), *facts(rows), table]
    if result is None:
        reason = found.left_out["identification"].rstrip(".")
        parts.append(Paragraph(f"Nothing can be identified in this record: {reason}.", strong=True))
    time = None if result is None or result.decay.driven else result.release.time_s
    caption = "The record." if time is None else "The record; dashed: the release."
    shaded = " Flagged samples are shaded." if flags else ""
    figure = record(recording, time, flags)
    return [*parts, Figure(f"{caption} Lost samples are left blank.{shaded}", figure)]


def _channel(found: Findings, channel: Channel) -> tuple[str, ...]:
    known = next((s for s in found.session.info.sensors if s.channel == channel.name), None)
    uncertainty, low, high = channel.calibration_uncertainty, channel.low, channel.high
    return (
        channel.name,
        channel.quantity,
        typeset_unit(channel.unit),
        channel.sensor or NOT_STATED,
        (known.calibrated if known else "") or NOT_STATED,
        NOT_STATED if uncertainty is None else f"{100 * uncertainty:.2g} %",
        "–" if channel.resolution is None else three_figures(channel.resolution),
        "–" if low is None or high is None else f"{low:.4g} to {high:.4g}",
    )


def _verdict(found: Findings) -> Paragraph:
    verdict = found.verdict
    if verdict is None:
        return Paragraph(f"none; {found.doubt}", label="Verdict on the recording", strong=True)
    advice = f". Before taking it again: {'; '.join(verdict.advice)}" if verdict.advice else ""
    return Paragraph(f"{verdict.words}{advice}", label="Verdict on the recording", strong=True)


def provenance(found: Findings) -> list[Part]:
    """List versions and the checksums of every file that the manifest knows, the report's own aside."""
    rows = [("Python", f"{platform.python_version()} on {platform.system()} {platform.machine()}")]
    rows += [(name, version_of(name, "not installed as a package")) for name in PACKAGES]
    parts: list[Part] = [Facts(tuple(rows))]
    if found.manifest is None:
        parts.append(left_out(found.left_out["checksums"], "Checksums"))
    else:
        files = sorted(found.manifest.files.items())
        table = tuple(
            (name, file.sha256, str(file.size)) for name, file in files if not name.endswith(".html")
        )
        parts.append(Table("Files of the session (SHA-256)", ("file", "checksum", "bytes"), table, texts=2))
        as_it_came = "raw.log holds every byte as it came; all results can be made again from it."
        parts.append(Paragraph(found.doubt or as_it_came))
    return parts
