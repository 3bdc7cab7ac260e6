"""Conversations with boards that lie, thousands of them by a clock of their own, on every core."""

import os
import resource
import sys
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

TITLE = "Boards that lie"

ROOT = Path(__file__).resolve().parent.parent
CONVERSATIONS = 4000
AT_ONCE = 100


@dataclass(frozen=True)
class Batch:
    """What a batch of conversations came to; `elapsed_s` and its limit by the boards' clock, memory in MB above the start."""

    ended: Counter[str]
    wrong: tuple[str, ...]
    elapsed_s: float
    limit_s: float
    log_bytes: int
    memory_mb: float


def converse(seeds: range) -> Batch:
    """Hold the conversations of these seeds in this process."""
    sys.path.insert(0, str(ROOT / "tests" / "daq"))
    from lying_conversation import LIMIT_S, converse

    ended: Counter[str] = Counter()
    wrong, elapsed, size, before = [], 0.0, 0, _peak_mb()
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            told = converse(seed, Path(folder) / str(seed))
            ended[told.verdict or "refused before START"] += 1
            elapsed, size = max(elapsed, told.elapsed_s), max(size, told.log_bytes)
            wrong += [f"{told.wrong}: {told.lies}"] if told.wrong else []
    return Batch(ended, tuple(wrong), elapsed, LIMIT_S, size, _peak_mb() - before)


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    count = 200 if quick else CONVERSATIONS
    seeds = [range(at, min(at + AT_ONCE, count)) for at in range(0, count, AT_ONCE)]
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        batches = list(pool.map(converse, seeds))
    ended = sum((batch.ended for batch in batches), Counter())
    wrong = [text for batch in batches for text in batch.wrong]
    text = (
        f"{count} conversations with boards that lie (13 kinds) or misbehave (24 kinds). OK, and not what the board sampled: "
        f"{len(wrong)} of {ended['OK']}. At most {max(b.elapsed_s for b in batches):.1f} s of the board's clock "
        f"({batches[0].limit_s:.0f} allowed), {max(batch.log_bytes for batch in batches) / 1e6:.1f} MB of log and "
        f"{max(batch.memory_mb for batch in batches):.0f} MB of memory."
    )
    return "\n".join([text, *(f"- {said}" for said in wrong)])
