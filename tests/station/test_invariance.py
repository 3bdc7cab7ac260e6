"""The same record told otherwise gets the same verdict: the quick part of `python -m bench invariance`.

The bench compares every printed digit. Here numbers may move by a share that no processor's last bits reach.
"""

import pytest

from bench.invariance import QUICK, Record, Said, all_at_once, judged, said_elsewhere, tables_of, turned

MOVED = 0.02
"""Share of a suspect's evidence by which it may move; a jitter of 1e-12 moves it by less than 1e-4."""


def alike(one: Said, other: Said) -> bool:
    named = (one.verdict, one.named, one.suspects) == (other.verdict, other.named, other.suspects)
    return named and one.moved(other) < MOVED


@pytest.mark.parametrize(
    "record", [QUICK[0], pytest.param(QUICK[1], marks=pytest.mark.slow)], ids=lambda record: record.title
)
def test_a_record_told_otherwise_gets_the_same_verdict(record: Record):
    tables = tables_of(record)
    as_it_is = judged(tables)
    for change in (all_at_once, turned):
        told = judged([change(table) for table in tables])
        assert alike(as_it_is, told), as_it_is.differs(told)


@pytest.mark.slow
def test_another_kernel_of_algebra_gives_the_same_verdict():
    record = QUICK[2]
    kernel = {"OPENBLAS_CORETYPE": "Prescott", "OPENBLAS_NUM_THREADS": "8"}
    ((title, told),) = said_elsewhere(True, record.title, kernel)
    assert title == record.title
    assert alike(judged(tables_of(record)), told)
