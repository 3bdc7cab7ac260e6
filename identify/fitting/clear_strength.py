"""A clear strength: whether an effect is there at all, against the misfit that is there."""

import numpy as np

from identify.fitting.fit import Fit
from identify.fitting.misfit_errors import as_white_misfit, with_misfit_errors
from identify.model.model import Term
from identify.priors import CLEAR

_RIDGE = 1e-9
"""Added to a correlation matrix of parameters, so that it has an inverse."""


def is_clear(whole: Fit, term: Term, *, predicted: bool) -> bool:
    """Whether the strength of an effect differs from none by some errors of the misfit that is there.

    Of one that curves have `predicted` the inner parameters are held at their values: at no strength they mean nothing, and
    with them free a strength that they trade with (a friction's stiffness and the displacement over which it gives way)
    is unsure however sure the force is (Davies 1977). Of any other they count as fitted: they bend to any guess. Of a
    predicted one the misfit counts as white noise: the prediction is its evidence, and the free run need only bear it out.
    """
    errors = as_white_misfit(whole) if predicted else with_misfit_errors(whole)
    name = str(term.strength)
    strength = errors.values[name]
    if not np.isfinite(strength.std):
        return False
    sureness = 1.0
    if predicted:
        own = [
            i
            for i, u in enumerate(errors.unknowns)
            if u.id.effect == term.effect.name and u.id.role == "parameter"
        ]
        at = [errors.unknowns[i].name for i in own].index(name)
        block = errors.covariance[np.ix_(own, own)]
        size = np.sqrt(np.diag(block))
        sureness = np.linalg.inv(block / np.outer(size, size) + _RIDGE * np.eye(len(own)))[at, at]
    return bool(abs(strength.value) * np.sqrt(sureness) > CLEAR * strength.std)
