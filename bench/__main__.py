"""`python -m bench [NAME...] [--quick]`: measure, and write the figures into docs/benchmarks.md.

Each module named in SECTIONS has `run(quick)`, which returns the text of its section, and may have a TITLE. A section
is found by its command, so that one can be measured again and the others stay.
"""

import argparse
import importlib
import re
import sys
from datetime import date
from pathlib import Path

SECTIONS = (
    "wire",
    "firmware",
    "exchange",
    "trust",
    "lies",
    "alignment",
    "identification",
    "invariance",
    "diagnosis",
    "waiting",
    "regimes",
    "rules",
    "bounds",
    "guide",
    "peers",
    "recordings",
    "rigs",
    "station",
    "campaign",
    "storage",
    "fuzz",
    "soak",
    "workbench",
)

SECTION_OF = re.compile(r"`python -m bench (\w+)")
PAGE = Path(__file__).resolve().parent.parent / "docs" / "benchmarks.md"
HEAD = """# Measured figures

Made by the command of each section, on two cores, on its date.
"""


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m bench", description="Measure and write docs/benchmarks.md."
    )
    parser.add_argument(
        "sections", nargs="*", metavar="NAME", help=f"any of {', '.join(SECTIONS)} (default: all)"
    )
    parser.add_argument("--quick", action="store_true", help="fewer repetitions; printed, not written")
    parser.add_argument("--write", action="store_true", help="write even a quick run")
    parser.add_argument("--minutes", type=float, help="minutes of fuzzing in all (default: 2 a reader)")
    chosen = parser.parse_args(arguments)
    unknown = sorted(set(chosen.sections) - set(SECTIONS))
    if unknown:
        parser.error(f"no section {', '.join(unknown)}; there are {', '.join(SECTIONS)}")
    failed = []
    for name in chosen.sections or SECTIONS:
        print(f"measuring: {name}", file=sys.stderr, flush=True)
        try:
            module = importlib.import_module(f"bench.{name}")
            more = {"minutes": chosen.minutes} if name == "fuzz" else {}
            body = str(module.run(chosen.quick, **more)).strip()
        except Exception as error:  # the other sections are worth having
            print(f"failed: {name}: {type(error).__name__}: {error}", file=sys.stderr)
            failed.append(name)
            continue
        title = getattr(module, "TITLE", name.capitalize())
        command = f"python -m bench {name}{' --quick' if chosen.quick else ''}"
        section = f"## {title}\n\n`{command}`, {date.today().isoformat()}\n\n{body}"
        print(section, flush=True)
        if chosen.write or not chosen.quick:
            write_section(PAGE, name, section)
    return 1 if failed else 0


def write_section(page: Path, name: str, section: str) -> None:
    """Replace the section of a bench, or put it where SECTIONS has it."""
    text = page.read_text(encoding="utf-8") if page.exists() else HEAD
    head, *sections = re.split(r"^(?=## )", text, flags=re.MULTILINE)
    named = {SECTION_OF.findall(one)[0]: one for one in sections} | {name: section}
    kept = [named[one].strip() for one in SECTIONS if one in named]
    page.parent.mkdir(exist_ok=True)
    page.write_text("\n\n".join([head.strip(), *kept]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
