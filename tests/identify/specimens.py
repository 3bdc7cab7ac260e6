"""Specimens of the double: something hidden of a size fixed at 20 mm, of which a release from any amplitude can be drawn."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from identify.diagnosis.diagnose import Diagnosis, diagnose
from identify.effects.effect import Effect
from identify.effects.library import find_effect
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw

MASS_KG = 21.36


def among(*names: str) -> tuple[Effect, ...]:
    """Return a library of these effects: what is hidden, and whatever could be taken for it."""
    return tuple(find_effect(name) for name in names)


FEW = among(
    "cubic_stiffness", "signed_quadratic_stiffness", "settling_stiffness", "time_varying_stiffness", "freeplay",
    "end_stop", "hysteresis", "quadratic_damping", "position_dependent_damping", "fading_damping",
    "harmonic_forcing", "mains_hum", "pendulum_stiffness",
)  # fmt: skip
"""Effects enough for a choice between them; the whole library takes several times as long."""


def diagnosed(*releases: FreeDecay | PreparedDecay, also: str = "") -> Diagnosis:
    """Diagnose releases together with these few effects, and one more."""
    more = (find_effect(also),) if also and also not in {effect.name for effect in FEW} else ()
    return diagnose(releases, library=(*FEW, *more))


@dataclass(frozen=True)
class Specimen:
    hidden: str | None
    strength: float
    seed: int

    @cached_property
    def made_of(self) -> dict[str, Any]:
        truth = draw(self.hidden, self.strength, self.seed, amplitude=0.02).truth
        names = list(truth["strengths"])
        found = truth["parameters"] if len(names) > 1 else dict.fromkeys(names, truth["parameters"])
        return {
            "parameters": {n: {k: v for k, v in p.items() if k != "z_start"} for n, p in found.items()},
            "stiffness": truth["stiffness_per_mass"],
            "mu_0": truth["mu_0"],
            "mu_1": truth["mu_1"],
            "lag": truth["displacement_late_s"],
            "noise_displacement": truth["noise_m"],
            "noise_acceleration": truth["noise_m_s2"],
        }

    def release(self, millimetres: float, number: int = 0) -> PreparedDecay:
        strength = self.strength if self.hidden else 0.0
        sample = draw(
            self.hidden, strength, 100 * self.seed + number, amplitude=1e-3 * millimetres, **self.made_of
        )
        return prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration, mass=MASS_KG))
