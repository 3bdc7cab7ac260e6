"""The order of a polynomial: how many terms a measurement asks for, and why no more."""

from collections.abc import Sequence

from identify.formatting import three_figures

CLEAR = 4.0  # standard errors by which a further coefficient must stand clear of zero


def choose_order(
    orders: Sequence[int],
    misfits: Sequence[float],
    clearances: Sequence[float],
    what: str,
    higher: str = "no higher order was tried",
) -> tuple[int, str]:
    """Return the chosen order and a sentence that says why.

    `orders` ascending; `misfits` the mean square error of each; `clearances` the highest coefficient of each
    over its standard error. The highest order is taken that stands clear of zero; the lowest needs no reason. `what`
    names the polynomial, `higher` says why there is none above these.
    """
    best = max(i for i in range(len(orders)) if i == 0 or clearances[i] > CLEAR)
    chosen = f"{what} of order {orders[best]}"
    if best == len(orders) - 1:
        return orders[best], f"{chosen}: {_gain(orders, misfits, best)}{higher}"
    away = clearances[best + 1]
    far = f"only {min(away, CLEAR - 0.1):.1f} standard errors from zero" if away >= 0.05 else "zero"
    why_not = f"the coefficient of order {orders[best + 1]} is {far}"
    if best == 0:
        return orders[0], f"{chosen} is enough: {why_not}"
    return orders[best], f"{chosen}: {_gain(orders, misfits, best)}{why_not}"


def _gain(orders: Sequence[int], misfits: Sequence[float], best: int) -> str:
    """Say what the order before the best one leaves of its misfit; "" for the lowest."""
    if best == 0:
        return ""
    times = misfits[best - 1] / max(misfits[best], 1e-300)
    size = three_figures(times) if times < 1000.0 else "over 1000"
    return f"order {orders[best - 1]} leaves {size} times its misfit; "
