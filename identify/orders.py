"""The order of a polynomial: how many terms a measurement asks for, and why no more."""

from collections.abc import Sequence

CLEAR = 4.0  # standard errors by which a further coefficient must stand clear of zero
WORTH = 0.85  # the misfit must fall at least to this share of the best lower order's
KNEE = 0.3  # and to this share where even then it stays well above the noise: the knee of fig. 3


def choose_order(
    orders: Sequence[int], misfits: Sequence[float], clearances: Sequence[float], noise: float, what: str
) -> tuple[int, str]:
    """Return the chosen order and a sentence that says why.

    `orders` ascending; `misfits` the mean square error of each; `clearances` the highest coefficient of each
    over its standard error; `noise` the mean square error that noise alone would leave. The highest order is
    taken whose own coefficient stands clear of zero and which lowers the misfit noticeably: a little where that
    brings it to the noise, much where it stays above. The lowest order needs no reason. `what` names the
    polynomial.
    """
    best = 0
    for i in range(1, len(orders)):
        share = WORTH if misfits[i] < 2 * noise else KNEE
        if clearances[i] > CLEAR and misfits[i] < share * min(misfits[:i]):
            best = i
    if best == len(orders) - 1:
        return orders[best], (
            f"{what} of order {orders[best]}: its coefficient is {clearances[best]:.0f} standard errors "
            "from zero, and no higher order was tried"
            if best
            else f"{what} of order {orders[0]}: no higher order was tried"
        )
    following = best + 1
    why_not = f"order {orders[following]} would stand {clearances[following]:.1f} standard errors from zero"
    if clearances[following] > CLEAR:
        why_not = (
            f"order {orders[following]} would lower the misfit only to "
            f"{100 * misfits[following] / max(misfits[best], 1e-300):.0f} % of it"
        )
    if best == 0:
        return orders[0], f"{what} of order {orders[0]} is enough: {why_not}"
    fall = misfits[best] / max(misfits[best - 1], 1e-300)
    return orders[best], (
        f"{what} of order {orders[best]}: it leaves {100 * fall:.2g} % of the misfit of order "
        f"{orders[best - 1]}; {why_not}"
    )
