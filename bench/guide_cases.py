"""Hidden cases for the guide: a specimen of which any release can be drawn, and who chooses the releases."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from identify.free_decay import FreeDecay
from identify.planning.experiment import Experiment
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw

LOW, HIGH = 0.002, 0.025
FIRST_SEED = 91000
LIMITS_WORDS = "2 to 25 mm"
REFERENCE = 0.02
NOISES = {"usual noise": 1.0, "five times the noise": 5.0}
GRID = np.linspace(LOW, HIGH, 5)

KINDS = {
    "single": (
        "cubic_stiffness", "quadratic_stiffness", "quintic_stiffness", "end_stop", "freeplay", "bilinear_stiffness",
        "quadratic_damping", "cubic_damping", "position_dependent_damping", "stribeck_friction",
        "position_dependent_friction", "hysteresis", "dahl_friction", "maxwell_element", "second_mass",
        "time_varying_stiffness", "settling_stiffness", "signed_quadratic_stiffness", "impact_with_loss", "harmonic_forcing",
        "fading_friction", "fading_damping",
    ),
    "pair": (
        "cubic_stiffness+quadratic_damping", "hysteresis+quadratic_damping", "end_stop+cubic_damping",
        "quadratic_stiffness+stribeck_friction", "freeplay+quadratic_damping", "cubic_stiffness+position_dependent_friction",
        "dahl_friction+cubic_stiffness", "bilinear_stiffness+cubic_damping",
    ),
    "near shape": ("power_law_stiffness", "power_law_damping", "bouc_wen_hysteresis", "lugre_friction") * 2,
    "sensor": ("mains_hum", "offset_drift", "clipping", "dropouts") * 2,
    "outside": (
        "magnet", "notched_spring", "amplitude_switched_damping", "one_way_cable", "one_sided_friction", "adhesion",
        "wandering_stiffness", "wandering_damping",
    ),
    "nothing": (None,) * 8,
}  # fmt: skip
ALSO_RIGHT = {
    "freeplay": ({"end_stop"},),
    "freeplay+quadratic_damping": ({"end_stop", "quadratic_damping"},),
    "lugre_friction": ({"dahl_friction", "stribeck_friction"},),
    "bouc_wen_hysteresis": ({"hysteresis"},),
}
"""Other names of the same law: freeplay is an end stop on both sides of another spring; and those that the library has."""


@dataclass(frozen=True)
class Case:
    """What is hidden, how strong it is at 20 mm (share of all forces), the noise, and the seed."""

    kind: str
    hidden: str | None
    strength: float
    noise: str
    seed: int

    @property
    def title(self) -> str:
        return f"{self.hidden or 'nothing'} {100 * self.strength:.2g} %, {self.noise}"

    @cached_property
    def specimen(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the parameters of what is hidden, and what is fixed of the bench and its sensors."""
        truth = draw(self.hidden, self.strength, self.seed, amplitude=REFERENCE).truth
        names = list(truth["strengths"])
        found = truth["parameters"] if len(names) > 1 else dict.fromkeys(names, truth["parameters"])
        pinned = {
            name: {key: value for key, value in values.items() if key not in ("z_start", "lost")}
            for name, values in found.items()
        }
        times = NOISES[self.noise]
        return pinned, {
            "stiffness": truth["stiffness_per_mass"],
            "mu_0": truth["mu_0"],
            "mu_1": truth["mu_1"],
            "lag": truth["displacement_late_s"],
            "offset_displacement": truth["offset_m"],
            "offset_acceleration": truth["offset_m_s2"],
            "noise_displacement": times * truth["noise_m"],
            "noise_acceleration": times * truth["noise_m_s2"],
        }

    def record(self, experiment: Experiment, number: int) -> PreparedDecay:
        """Draw one release; NotIdentifiable where it holds too little."""
        pinned, fixed = self.specimen
        fixed |= {"seconds": 8.0 * experiment.longer, "rate": 256.0 * experiment.faster}
        if experiment.push:
            start = {"amplitude": 0.0, "velocity": experiment.amplitude * math.sqrt(fixed["stiffness"])}
            start["release_time"] = 0.004
        else:
            start = {"amplitude": experiment.amplitude}
        strength = self.strength if self.hidden else 0.0
        seed = 100 * self.seed + number
        sample = draw(self.hidden, strength, seed, parameters=pinned, **(fixed | start))
        return prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration, mass=21.36))

    def right(self, state: str, *names: tuple[str, ...]) -> bool:
        """Whether that is what is hidden; of several `names` that are not distinguishable, whether each is."""
        if self.kind == "nothing":
            return state == "nothing"
        if self.kind == "outside":
            return state == "no_name"
        hidden = set((self.hidden or "").split("+"))
        wanted = (hidden, *ALSO_RIGHT.get(self.hidden or "", ()))
        return state in ("confirmed", "alike") and all(set(named) in wanted for named in names)

    def false(self, state: str, *names: tuple[str, ...]) -> bool:
        """Whether something is claimed that is not there; of several `names` that are not distinguishable, whether none is."""
        there = set((self.hidden or "").split("+")).union(*ALSO_RIGHT.get(self.hidden or "", ()))
        return state in ("confirmed", "alike") and not any(
            named and there.issuperset(named) for named in names
        )


FRESH = 2000
"""Added to the seeds of the cases that the guide was made on: those of the proof, which nobody had looked at."""


def cases(offset: int = FRESH) -> list[Case]:
    """Return the sixty of some seeds, noise and strength taking turns."""
    found = []
    for kind, names in KINDS.items():
        for i, name in enumerate(names):
            seed = FIRST_SEED + offset + len(found)
            random = np.random.default_rng([seed, 12])
            strength = math.exp(random.uniform(math.log(0.005), math.log(0.03))) if name else 0.0
            later = kind in ("near shape", "sensor") and i >= len(names) // 2
            noise = list(NOISES)[(i + later) % 2]
            found.append(Case(kind, name, strength, noise, seed))
    return found


def amplitudes(policy: str, seed: int, first: float) -> list[float]:
    """Return the amplitudes (m) of a policy that does not look at what it found; the guide has only a first one."""
    random = np.random.default_rng([seed, 77])
    sides = random.choice([-1.0, 1.0], 12)
    sizes = random.uniform(LOW, HIGH, 12)
    return {
        "guide": [first],
        "same": [first] * 12,
        "grid": [float(a * (-1.0) ** i) for i, a in enumerate((*GRID, *GRID))],
        "random": [float(side * size) for side, size in zip(sides, sizes, strict=True)],
    }[policy]
