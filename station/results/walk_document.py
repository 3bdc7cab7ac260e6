"""A walk of spring and damper that explains a misfit, as a document."""

from station.results.documents import Number, Part


class WalkDocument(Part):
    """A walk's `evidence` (nats), its standard deviations after one second, and the reduced chi-square beside it.

    `stiffness` is relative to the linear stiffness, `damping` to the angular frequency: twice that of the damping ratio.
    """

    evidence: Number
    stiffness: Number
    damping: Number
    reduced: Number
