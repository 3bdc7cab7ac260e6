"""The last section: with which software, from which files; their checksums as the manifest holds them."""

import platform
from importlib.metadata import PackageNotFoundError, version

from station.report.findings import Findings
from station.text.content import Facts, Paragraph, Part, Table

PACKAGES = ("free-decay-station", "numpy", "scipy", "numba", "matplotlib")


def provenance(found: Findings) -> list[Part]:
    """List versions and the checksums of every file that the manifest knows, the report's own aside."""
    rows = [("Python", f"{platform.python_version()} on {platform.system()} {platform.machine()}")]
    rows += [(name, _version(name)) for name in PACKAGES]
    parts: list[Part] = [Facts(tuple(rows))]
    if found.manifest is None:
        parts.append(Paragraph(f"Left out: {found.left_out['checksums']}.", label="Checksums"))
    else:
        files = sorted(found.manifest.files.items())
        table = tuple(
            (name, str(file.size), file.sha256) for name, file in files if not name.endswith(".html")
        )
        parts.append(
            Table("Files of the session (SHA-256)", ("file", "bytes", "checksum"), table, texts=1, wordy=True)
        )
        parts.append(Paragraph("raw.log holds every byte as it came; all results can be made again from it."))
    return parts


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed as a package"
