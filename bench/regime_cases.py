"""Cases of other noise and other working points: what is hidden, what is drawn, and the releases of it."""

from dataclasses import dataclass
from typing import Any

from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw
from mocks.imperfections import IMPERFECTIONS

WHITE, COARSE, ALL = "white", "12 bits, quiet", "all of them"
NOISES = (WHITE, *IMPERFECTIONS, COARSE, ALL)
POINTS = ("4 Hz", "1 Hz", "40 Hz", "one channel", "no friction", "mid-decay", "angle")
MANY = (WHITE, "one_over_f", ALL)
"""Noises under which a quick run tries nine releases together: each takes as long as twenty single ones."""

EFFECTS = ("cubic_stiffness", "quadratic_damping", "hysteresis", "second_mass", "freeplay")
TRIPLES = (
    "cubic_stiffness+quadratic_damping+stribeck_friction",
    "hysteresis+cubic_stiffness+quadratic_damping",
    "end_stop+cubic_damping+harmonic_forcing",
    "freeplay+quadratic_damping+second_mass",
    "cubic_stiffness+cubic_damping+position_dependent_friction",
    "quadratic_stiffness+hysteresis+freeplay",
    "time_varying_stiffness+quadratic_damping+cubic_stiffness",
    "bilinear_stiffness+stribeck_friction+position_dependent_damping",
)
NEAR_SHAPES = ("power_law_stiffness", "power_law_damping", "bouc_wen_hysteresis", "lugre_friction")
STRENGTH, OF_EACH_OF_THREE = 0.03, 0.02
USUAL_HZ = 3.944
"""Frequency of the double's bench: at other frequencies all of it, sampling too, runs in another time."""


@dataclass(frozen=True)
class Case:
    """What is hidden, the noise, the working point, how many releases, and the seed of the first."""

    hidden: str | None
    noise: str
    point: str
    releases: int
    seed: int


def release_of(case: Case, number: int) -> PreparedDecay:
    """Draw one release of a case: of one specimen with one pair of sensors, each from its own height."""
    seed = case.seed + 1000 * number
    strength = OF_EACH_OF_THREE if case.hidden in TRIPLES else STRENGTH
    sample = draw(case.hidden, strength if case.hidden else 0.0, seed, **fixed(case, number))
    u, a = sample.displacement, sample.acceleration
    if case.point == "one channel":
        return prepare(FreeDecay(sample.rate, displacement=u))
    if case.point == "mid-decay":
        first = round(1.7 * sample.rate)
        return prepare(FreeDecay(sample.rate, u[first:], a[first:]))
    if case.point == "angle":
        return prepare(FreeDecay(sample.rate, displacement=u / 0.1, acceleration=a / 0.1, unit="rad"))
    return prepare(FreeDecay(sample.rate, u, a))


def fixed(case: Case, number: int) -> dict[str, Any]:
    """Return what a case pins of the double's bench."""
    drawn = draw(None, 0.0, case.seed, seconds=1.0).truth
    pace = {"1 Hz": 1.0, "40 Hz": 40.0}.get(case.point, USUAL_HZ) / USUAL_HZ
    result: dict[str, Any] = {
        "stiffness": drawn["stiffness_per_mass"] * pace**2,
        "mu_0": drawn["mu_0"] * pace**2,
        "mu_1": drawn["mu_1"] * pace,
        "rate": 256.0 * pace,
        "seconds": 8.0 / pace,
        "rest": 0.75 / pace,
        "noise_displacement": drawn["noise_m"],
        "noise_acceleration": drawn["noise_m_s2"] * pace**2,
        "range_acceleration": 50.0 * pace**2,
        "release_time": drawn["hand_s"] / pace,
        "released_at": drawn["released_at_s"] / pace,
        "lag": drawn["displacement_late_s"] / pace,
        "sensor_pair": case.seed,
    }
    if number:
        result["amplitude"] = drawn["from_m"] * (1.0 - 0.06 * number)
    if case.point == "no friction":
        result |= {"mu_0": 0.0}
    names = IMPERFECTIONS if case.noise == ALL else (case.noise,) if case.noise in IMPERFECTIONS else ()
    result["imperfections"] = names
    if case.noise in (COARSE, ALL):
        result["bits"] = 12
        if case.noise == COARSE:
            steps = 2.0 / 2.0**12
            result["noise_displacement"] = 0.03 * steps * 0.05
            result["noise_acceleration"] = 0.03 * steps * 50.0 * pace**2
    return result


def cases_of(
    noises: tuple[str, ...],
    points: tuple[str, ...],
    releases: tuple[int, ...],
    seeds: int,
    hidden: tuple[str | None, ...] = (None,),
    first: int = 0,
) -> list[Case]:
    """Return every combination."""
    return [
        Case(h, noise, point, count, 60000 + first + i)
        for i in range(seeds)
        for noise in noises
        for point in points
        for count in releases
        for h in hidden
    ]


def cases_in_turn(seeds: int, first: int) -> list[Case]:
    """Return every noise at every working point with one of the effects each, which come in turn."""
    return [
        Case(EFFECTS[(i + row + column) % len(EFFECTS)], noise, point, 1, 60000 + first + i)
        for i in range(seeds)
        for row, noise in enumerate(NOISES)
        for column, point in enumerate(POINTS)
    ]
