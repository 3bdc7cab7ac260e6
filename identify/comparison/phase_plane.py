"""The phase plane: the force that the model lacks, in bins of displacement and velocity."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, frozen
from identify.comparison.multiple_shooting import MultipleShooting
from identify.comparison.residual_force import estimate_extra_force

_KNOWN = 8.0

FEWEST = 12
"""Samples or so in each bin that is visited."""


@dataclass(frozen=True, eq=False)
class PhasePlane:
    """Residual force per unit mass (m/s^2, measured less model, on the left of u'' + ... = 0) in bins.

    Edges of an odd number of bins `displacement_edges` (p + 1,) and of an even number `velocity_edges` (q + 1,), so that
    zero velocity is an edge and both directions stay apart. `force`, `std` (nan where the mass never was, or so
    briefly that nothing is known): (q, p).
    `bins` (known, 2) are the rows and columns of the bins that are known and `covariance` (known, known) theirs;
    `chi_square_after` is the reduced chi-square within the cycles that such a force would leave.
    """

    displacement_edges: Array
    velocity_edges: Array
    force: Array
    std: Array
    bins: Array
    covariance: Array
    chi_square_after: float

    @property
    def displacement(self) -> Array:
        """Middles of the bins, m."""
        return (self.displacement_edges[1:] + self.displacement_edges[:-1]) / 2.0

    @property
    def velocity(self) -> Array:
        """Middles of the bins, m/s."""
        return (self.velocity_edges[1:] + self.velocity_edges[:-1]) / 2.0


def compare_phase_plane(shooting: MultipleShooting, fewest: int = FEWEST) -> PhasePlane:
    """Return the force that the tracked model lacks, as one constant in each bin of the phase plane.

    About `fewest` samples or more lie in each of the bins that are visited.
    """
    across = _odd(len(shooting.displacement), fewest)
    along = across - 1
    edges_u, edges_v, code, patterns = _bins(shooting, across)
    size, covariance, chi_square_after = estimate_extra_force(shooting, patterns)
    errors = np.sqrt(np.diag(covariance))
    known = errors < _KNOWN * np.median(errors)
    bins = np.column_stack([code // across, code % across])[known]
    force, std = np.full((along, across), np.nan), np.full((along, across), np.nan)
    force[bins[:, 0], bins[:, 1]] = size[known]
    std[bins[:, 0], bins[:, 1]] = errors[known]
    bins.setflags(write=False)
    return PhasePlane(
        frozen(edges_u),
        frozen(edges_v),
        frozen(force),
        frozen(std),
        bins,
        frozen(covariance[np.ix_(known, known)]),
        chi_square_after,
    )


def _odd(samples: int, fewest: int) -> int:
    """Return an odd number of bins across: about so many samples in each of the bins that are visited."""
    return 2 * int(np.clip(np.sqrt(samples / (3.0 * fewest)), 2.0, 66.0 / fewest)) + 1


def _bins(shooting: MultipleShooting, across: int) -> tuple[Array, Array, Array, Array]:
    """Divide the phase plane into `across` bins of displacement, times one fewer of velocity.

    Returns the edges of both, the visited bins as row times `across` plus column, (bins,), and a force of one in each of
    them, (n, bins).
    """
    edges, place = [], []
    for values, count in ((shooting.displacement, across), (shooting.velocity, across - 1)):
        edges.append(np.linspace(-1.0, 1.0, count + 1) * float(np.max(np.abs(values))) * (1.0 + 1e-9))
        place.append(np.clip(np.searchsorted(edges[-1], values, side="right") - 1, 0, count - 1))
    code, member = np.unique(place[1] * across + place[0], return_inverse=True)
    return edges[0], edges[1], code, (member[:, None] == np.arange(len(code))).astype(float)
