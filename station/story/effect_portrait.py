"""An effect at typical values: its force along one cycle, and what it does to decay and frequency."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.effects.effect import Effect, Scales
from identify.effects.force_effect import ForceEffect
from identify.model.equivalent_linearisation import Signature, average

Array = NDArray[np.float64]

AMPLITUDES = {"m": 0.02, "rad": 1.0}
"""The largest amplitude that is drawn, by the unit of the displacement."""

FREQUENCY = 2.0 * np.pi * 4.0

SHARE = 0.01

_POINTS = 4000

_CYCLES = 6


@dataclass(frozen=True, eq=False)
class Portrait:
    """An effect at typical values: 20 mm (1 rad if it acts on angles only), 4 Hz, and about 1 % of the springs' force.

    `displacement`, `velocity`, `force` (n,) of one settled cycle at the largest amplitude; `signature` over amplitudes.
    `unit` is that of the displacement, m or rad.
    """

    unit: str

    values: dict[str, float]
    displacement: Array
    velocity: Array
    force: Array
    signature: Signature

    @property
    def length(self) -> tuple[str, float]:
        """The unit in which displacements are shown, and how many of it make one of `unit`."""
        return ("mm", 1e3) if self.unit == "m" else (self.unit, 1.0)


def portray(effect: Effect) -> Portrait:
    """Return the portrait of a force; raises ValueError for a fault of a sensor, which has no force."""
    if not isinstance(effect, ForceEffect):
        raise ValueError(f"{effect.name} is a fault of a sensor: it has no force to draw")
    unit = effect.units[0] if effect.units else "m"
    amplitude = AMPLITUDES[unit]
    values = _typical(effect, amplitude)
    time = np.arange(_POINTS * _CYCLES) / (_POINTS * FREQUENCY / (2.0 * np.pi))
    u, v = amplitude * np.cos(FREQUENCY * time), -amplitude * FREQUENCY * np.sin(FREQUENCY * time)
    p = effect.table(values, values)
    states = effect.states_along(p, time, u, v, effect.states_at_rest(amplitude, p))
    force = effect.force_along(p, time, u, v, states)
    target = SHARE * FREQUENCY**2 * amplitude
    largest = float(np.max(np.abs(force[-_POINTS:])))
    factor = target / largest if largest > 0 else 1.0
    values[effect.strength.name] *= factor
    last = slice(len(time) - _POINTS, None)
    amplitudes = np.linspace(0.05, 1.0, 39) * amplitude
    moment = 1.0 if effect.shared_parameters else 0.0
    signature = average(effect, values, FREQUENCY, amplitudes, time=moment)
    return Portrait(unit, values, u[last], v[last], force[last] * factor, signature)


def _typical(effect: ForceEffect, amplitude: float) -> dict[str, float]:
    scales = Scales(
        amplitude,
        FREQUENCY,
        8.0,
        256.0,
        {"displacement": amplitude, "acceleration": amplitude * FREQUENCY**2},
        {"displacement": ((9.3, 5e-3 * amplitude, 1.0),)},
    )
    starts = effect.starts(scales)
    inner = [p for p in effect.started if p.name not in effect.variants[0]]
    middle = starts[len(starts) // 2] if starts else ()
    values = {effect.strength.name: 1.0}
    values |= {p.name: value for p, value in zip(inner, middle, strict=False)}
    values |= {name: float(value) for name, value in effect.variants[0].items()}
    for parameter in effect.parameters:
        values.setdefault(parameter.name, 1.0)
    return values | {name: roughly(FREQUENCY) for name, roughly in effect.shared_parameters.items()}
