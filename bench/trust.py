"""Every fault of docs/faults.md, injected on a pty and a socket, in real time and over several seeds."""

import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

TITLE = "Faults survived"

HERE = Path(__file__).resolve().parent.parent
SEEDS = 3
FAST = 16.0
TIMING = ("--duration", "3")
WORKERS = 4  # a capture mostly waits for its board
STALLS = 5


def _harness() -> None:
    """The tests' own harness: what is measured here is what they hold."""
    sys.path.insert(0, str(HERE / "tests" / "end_to_end"))


def _try(number: int, line: str, speed: float, seed: int) -> str:
    """Inject one fault; return the promise that was broken, empty when all were kept."""
    _harness()
    from fault_bench import broken_promises, inject, promises

    promise = promises()[number]
    with tempfile.TemporaryDirectory() as folder:
        found = broken_promises(promise, inject(promise, line, Path(folder), speed, seed, *TIMING))
    name = f"{promise.fault} on {line}, seed {seed}, speed {speed:g}"
    print(f"{name}: {found or 'kept'}", file=sys.stderr, flush=True)
    return f"{name}: {'; '.join(found)}" if found else ""


def _tried(speed: float, seeds: range) -> tuple[int, list[str]]:
    """Return how many faults were injected and the promises that were broken."""
    _harness()
    from fault_bench import promises

    cases = [
        (number, line, speed, seed)
        for seed in seeds
        for number, promise in enumerate(promises())
        for line in promise.lines
    ]
    with ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
        broken = list(pool.map(_try, *zip(*cases, strict=True)))
    return len(cases), [text for text in broken if text]


def _silences(count: int) -> list[str]:
    """Return rows: how long a stalled board's silence lasts until it is announced, and until it is given up."""
    _harness()
    from fault_bench import silence

    rows = []
    for line in ("pty", "tcp"):
        times = []
        for number in range(count):
            with tempfile.TemporaryDirectory() as folder:
                times.append(silence(line, Path(folder), 1.5 + 0.3 * number))
        announced, given_up = zip(*times, strict=True)
        rows.append(f"| {line} | {count} | {max(announced):.2f} | {max(given_up):.2f} |")
    return rows


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    seeds = 1 if quick else SEEDS
    fast = _tried(FAST, range(1, seeds + 1))
    real = (0, []) if quick else _tried(1.0, range(1, 2))
    lines = [
        f"Of {tried} [faults](faults.md) {name}, each on every line that it can strike, {tried - len(broken)} ended as promised."
        for name, (tried, broken) in (("sixteen times as fast as life", fast), ("in real time", real))
        if tried
    ]
    lines += [f"- broken: {text}" for text in (*fast[1], *real[1])]
    lines += [
        "",
        "| a stalled board on | stalls | announced after, s (longest) | given up and closed after, s (longest) |",
    ]
    lines += ["|---|---:|---:|---:|", *_silences(1 if quick else STALLS)]
    return "\n".join(lines)
