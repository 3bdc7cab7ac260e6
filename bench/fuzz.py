"""Every reader of files under coverage-guided fuzzing: one process a reader, with a limit on memory and on time."""

import argparse
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

TITLE = "Bad input"
ROOT = Path(__file__).resolve().parent.parent
MEMORY = 4 << 30
SLICE_S = 120
SLOW_S = 10


def fuzz(name: str, seconds: float, folder: Path) -> None:
    """In a process of its own: fuzz one reader until the time is over or something escapes."""
    import atheris

    with atheris.instrument_imports(include=["daq", "station", "identify.effects", "firmware_protocol"]):
        from bench.readers import attempt, readers
    reader = next(one for one in readers(folder) if one.name == name)
    corpus = folder / "corpus"
    corpus.mkdir()
    for i, seed in enumerate(reader.seeds):
        (corpus / f"seed{i}").write_bytes(seed)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    options = [
        f"-max_total_time={seconds:.0f}",
        f"-timeout={SLOW_S}",
        "-max_len=8192",
        "-rss_limit_mb=0",
        "-print_final_stats=1",
    ]
    atheris.Setup(
        [sys.argv[0], *options, f"-artifact_prefix={folder}/", str(corpus)],
        lambda data: attempt(reader, data, folder) and None,
    )
    atheris.Fuzz()


def run_one(name: str, seconds: float) -> tuple[int, int, int, str]:
    """Inputs tried, coverage at the start and at the end, and what escaped."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "bench.fuzz", name, str(seconds), folder]
        try:
            done = subprocess.run(
                command,
                cwd=ROOT,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=seconds + 300,
            )
        except subprocess.TimeoutExpired:
            return 0, 0, 0, "it did not end"
    said = done.stderr + done.stdout
    cover = [int(n) for n in re.findall(r"\bcov: (\d+)", said)]
    tried = (
        re.findall(r"number_of_executed_units: (\d+)", said) or re.findall(r"^#(\d+)", said, re.M) or ["0"]
    )
    escaped = ""
    if done.returncode:
        print(said[-3000:], file=sys.stderr)
        found = re.findall(
            r"^(?:\w+\.)*\w+(?:Error|Exception|Warning|Exit)\b.*|^.*(?:timeout after|libFuzzer: ).*",
            said,
            re.M,
        )
        escaped = (found or [f"exit {done.returncode}"])[0][:150]
    return int(tried[-1]), cover[0] if cover else 0, cover[-1] if cover else 0, escaped


def run(quick: bool, minutes: float | None = None) -> str:
    from bench.readers import readers

    with tempfile.TemporaryDirectory() as folder:
        names = [reader.name for reader in readers(Path(folder))]
    seconds = 5.0 if quick else SLICE_S if minutes is None else 60 * minutes / len(names)
    total, left = 0, []
    for name in names:
        tried, begin, end, escaped = run_one(name, seconds)
        print(
            f"{name}: {tried} inputs, coverage {begin} to {end}, {escaped or 'nothing found'}",
            file=sys.stderr,
        )
        total += tried
        left += [f"{name}: {escaped}"] if escaped else []
    return (
        f"{total} inputs by atheris from valid files to {len(names)} readers; more than {SLOW_S} s or {MEMORY >> 30} GB is a finding. "
        f"Findings left: {'; '.join(left) or 'none'}."
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("name")
    parser.add_argument("seconds", type=float)
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    fuzz(given.name, given.seconds, given.folder)
