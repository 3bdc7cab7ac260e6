"""The operator's table: separators, decimal commas, dates, texts; what is no such table is refused in a sentence."""

from datetime import UTC, datetime

import numpy as np
import pytest
from many_sessions import make_session

from daq.session import Session
from station.campaign.metadata import read_metadata
from station.exits import UsageProblem
from station.operations.new_session import session_info
from station.settings import Settings


def table(folder, text):
    file = folder / "known.csv"
    file.write_text(text, encoding="utf-8-sig")
    return read_metadata(file)


def test_numbers_go_by_the_sessions_name_and_empty_cells_are_left_out(tmp_path):
    found, notes = table(tmp_path, "Session,temperature [degC],weight\na,21.5,3\n\nb,,nan\n")
    assert found["a"].conditions == {"temperature [degC]": 21.5, "weight": 3.0}
    assert found["b"].conditions == {}
    assert notes == ("known.csv: weight holds text: no trend is computed for it",)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_decimal_comma_is_read_where_commas_do_not_separate(tmp_path, separator):
    text = f"temperature [degC]{separator}session\n21,5{separator}a\n"
    assert table(tmp_path, text)[0]["a"].conditions == {"temperature [degC]": 21.5}


def test_a_date_without_a_zone_is_universal_time(tmp_path):
    found, _ = table(tmp_path, "session,date\na,2026-03-01\nb,2026-03-01T14:30+02:00\n")
    assert found["a"].date == datetime(2026, 3, 1, tzinfo=UTC)
    assert found["b"].date.astimezone(UTC) == datetime(2026, 3, 1, 12, 30, tzinfo=UTC)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a,b\n1,2\n", "no column is called session"),
        ("session,date\na,1.3.\n", "line 2: '1.3.' is no date"),
        ("", "no column"),
    ],
)
def test_what_is_no_such_table_is_refused(tmp_path, text, sentence):
    with pytest.raises(UsageProblem, match=sentence):
        table(tmp_path, text)


def test_conditions_are_typed_with_their_unit_and_survive_in_the_session(tmp_path):
    info = session_info(Settings(), None, None, None, None, ("temperature [degC]=-2.5", "a=b=3"))
    assert info.conditions == {"temperature [degC]": -2.5, "a=b": 3.0}
    session = make_session(tmp_path / "s", 256.0, np.ones((2, 8)), info)
    assert Session.open(session.folder).info.conditions == info.conditions


@pytest.mark.parametrize("text", ["temperature", "=3", "temperature=warm", "temperature=nan"])
def test_a_condition_that_is_no_number_is_refused(text):
    with pytest.raises(UsageProblem, match="write NAME=NUMBER"):
        session_info(Settings(), None, None, None, None, (text,))
