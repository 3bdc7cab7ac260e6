"""Every fault of docs/faults.md, injected on a pty and a socket, in real time and over many seeds."""

import sys
import tempfile
from pathlib import Path

TITLE = "Faults survived"

HERE = Path(__file__).resolve().parent.parent
SEEDS = 10
TIMING = ("--duration", "3")


def _tried(speed: float, seeds: range) -> tuple[int, list[str]]:
    """Return how many faults were injected and the promises that were broken."""
    sys.path.insert(0, str(HERE / "tests" / "end_to_end"))
    from fault_bench import broken_promises, inject, promises

    tried, broken = 0, []
    for promise in promises():
        for line in promise.lines:
            for seed in seeds:
                with tempfile.TemporaryDirectory() as folder:
                    outcome = inject(promise, line, Path(folder), speed, seed, *TIMING)
                    found = broken_promises(promise, outcome)
                tried += 1
                broken += [f"{promise.fault} on {line}, seed {seed}: {'; '.join(found)}"] if found else []
                print(
                    f"{promise.fault} on {line}, seed {seed}: {found or 'kept'}", file=sys.stderr, flush=True
                )
    return tried, broken


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    seeds = 1 if quick else SEEDS
    fast = _tried(16.0, range(1, seeds + 1))
    real = (0, []) if quick else _tried(1.0, range(1, 2))
    lines = ["| run | injected | ended as promised |", "|---|---:|---:|"]
    for name, (tried, broken) in (("sixteen times as fast as life", fast), ("in real time", real)):
        if tried:
            lines.append(f"| {name} | {tried} | {tried - len(broken)} |")
    lines += ["", f"Faults, lines and promises: the table in docs/faults.md; {seeds} seed(s)."]
    lines += [f"- broken: {text}" for text in (*fast[1], *real[1])]
    return "\n".join(lines)
