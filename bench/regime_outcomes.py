"""Outcomes of cases of other noise: what the station said, and whether that is true."""

import math
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: a process a core is enough

from bench.regime_cases import ALL, Case, release_of
from identify.diagnosis.diagnose import diagnose
from identify.errors import NotIdentifiable

OWN_NAMES = {
    "hum": ("mains_hum",),
    "aliased_line": ("mains_hum",),
    "bend": ("sensor_nonlinearity",),
    "bandwidth": ("sensor_bandwidth",),
}
"""What may be named: the imperfection itself is there."""

WORKERS = int(os.environ.get("BENCH_WORKERS", "2"))


@dataclass(frozen=True)
class Outcome:
    """What the station said of a case; `evidence` (nats) is that for the first suspect."""

    case: Case
    verdict: str
    named: tuple[str, ...]
    evidence: float
    chi_square: float
    seconds: float

    @property
    def false(self) -> bool:
        """Whether something is named that is not there; a crash is no better."""
        return self.verdict.startswith("crashed") or not set(self.named) <= self.there

    @property
    def nameless(self) -> bool:
        """Whether something is held to be missing that has no name."""
        return self.verdict in ("unknown_effect", "unconfirmed", "driven")

    @property
    def made_up(self) -> bool:
        """Whether two effects or more are named, of which one at most is there."""
        return len(self.named) > 1

    @property
    def there(self) -> set[str]:
        """What may be named: what is hidden, and the imperfections of the sensors."""
        return set((self.case.hidden or "").split("+")) | set(own_names(self.case.noise))

    @property
    def found(self) -> bool:
        """Whether all that is hidden is among the names, and nothing else but what is there."""
        return set((self.case.hidden or "").split("+")) <= set(self.named) and not self.false


def own_names(noise: str) -> tuple[str, ...]:
    """Return the names that are true of a kind of noise."""
    if noise == ALL:
        return tuple(name for names in OWN_NAMES.values() for name in names)
    return OWN_NAMES.get(noise, ())


def judge(case: Case) -> Outcome:
    """Let the station judge one case."""
    began = time.perf_counter()
    try:
        found = diagnose(tuple(release_of(case, number) for number in range(case.releases)))
    except Exception as error:  # a crash is an outcome
        kind = "refused" if isinstance(error, NotIdentifiable) else "crashed"
        return Outcome(case, f"{kind}: {error}", (), 0.0, math.nan, time.perf_counter() - began)
    return Outcome(
        case,
        found.verdict,
        found.named,
        found.suspects[0].evidence if found.suspects else 0.0,
        found.final.reduced,
        time.perf_counter() - began,
    )


def judge_all(cases: list[Case]) -> list[Outcome]:
    """Judge cases on two cores, printing each as it is done."""
    out = []
    with ProcessPoolExecutor(WORKERS) as pool:
        for future in as_completed([pool.submit(judge, case) for case in cases]):
            o = future.result()
            out.append(o)
            mark = "FALSE" if o.false else "found" if o.found else "missed" if o.case.hidden else "ok"
            mark = "nameless" if o.nameless and not o.case.hidden else mark
            print(
                f"{o.case.noise:15} {o.case.point:12} x{o.case.releases} {o.case.hidden or '-':18} {o.case.seed} "
                f"{mark:6} {o.verdict} {'+'.join(o.named)} {o.evidence:.1f} nats chi2 {o.chi_square:.3g} {o.seconds:.1f} s",
                file=sys.stderr,
                flush=True,
            )
    return out
