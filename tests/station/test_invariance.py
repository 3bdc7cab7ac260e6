"""The same record told otherwise gets the same verdict: the quick part of `python -m bench invariance`.

The bench compares every printed digit, under other kernels of algebra, too. Here numbers may move by a share that no
processor's last bits reach.
"""

from bench.invariance import QUICK, Said, all_at_once, judged, tables_of, turned
from identify.effects.library import find_effect
from tests.conftest import FEW

MOVED = 0.02
"""Share of a suspect's evidence by which it may move; a jitter of 1e-12 moves it by less than 1e-4."""

LIBRARY = tuple(map(find_effect, (*FEW, "stribeck_friction", "position_dependent_friction", "dahl_friction")))


def alike(one: Said, other: Said) -> bool:
    named = (one.verdict, one.named, one.suspects) == (other.verdict, other.named, other.suspects)
    return named and one.moved(other) < MOVED


def test_a_record_told_otherwise_gets_the_same_verdict(monkeypatch):
    monkeypatch.setattr("station.operations.diagnosing.whole_library", lambda file: LIBRARY)
    tables = tables_of(QUICK[0])
    as_it_is = judged(tables)
    told = judged([turned(all_at_once(table)) for table in tables])
    assert as_it_is.named == ("stribeck_friction",)
    assert alike(as_it_is, told), as_it_is.differs(told)
