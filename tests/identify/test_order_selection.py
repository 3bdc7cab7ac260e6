"""Why a polynomial has no more terms."""

import pytest

from identify.signal.order_selection import choose_order


@pytest.mark.parametrize(("away", "said"), [(2.14, "only 2.1"), (3.97, "only 3.9"), (0.01, "is zero")])
def test_a_coefficient_that_is_too_near_zero_is_not_said_to_be_as_far_as_is_needed(
    away: float, said: str
) -> None:
    order, why = choose_order((0, 1), (1.0, 0.5), (9.0, away), "damping")
    assert order == 0
    assert said in why
