"""Motion: displacement, velocity and acceleration that agree with each other."""

from dataclasses import dataclass

from identify.arrays import Array, Mask


@dataclass(frozen=True, eq=False)
class Motion:
    """Consistent displacement (m), velocity (m/s), acceleration (m/s^2), each of shape (n,).

    `start` is the index of the first sample in the record they were made from, `rate` is in Hz; `valid` is
    False where a sample was lost or an edge makes the values unreliable. `source` says which channels
    they were made from ("displacement and acceleration", "acceleration", "displacement", "velocity").
    `noise_velocity` and `noise_acceleration` are the standard errors of a sample, where known.
    """

    rate: float
    start: int
    displacement: Array
    velocity: Array
    acceleration: Array
    valid: Mask
    source: str
    noise_velocity: float | None = None
    noise_acceleration: float | None = None
