"""What a faulty sensor adds to its channel, and how large the fault must be for its strength.

Strength is the rms of the error over the rms of the channel, both from the release on; of a
drift, both about their means, since a constant error is an offset and no fault.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from mocks.sensors import high_pass

#: The faults, and what each is described by besides its channel.
SENSOR_FAULTS: dict[str, tuple[str, ...]] = {
    "channel_lag": ("lag",),
    "channel_gain": ("error",),
    "offset_drift": ("rate",),
    "clipping": ("limit",),
    "sensor_nonlinearity": ("quadratic", "cubic"),
    "ac_coupling": ("fc",),
    "sensor_bandwidth": ("fc",),
    "mains_hum": ("amp", "f", "phase"),
    "dropouts": ("kind", "lost"),
}
#: Those whose error depends on nothing but the signal and the time of that instant.
IMMEDIATE = ("channel_gain", "offset_drift", "clipping", "sensor_nonlinearity", "mains_hum")
#: Those that filter the signal, and the corners (Hz) at which they are hardly and fully there.
FILTERS = {"ac_coupling": (1e-4, 20.0), "sensor_bandwidth": (4e3, 1.0)}
OVERSAMPLING = 16


def rms(signal: np.ndarray) -> float:
    """Return the root mean square of a signal."""
    return float(np.sqrt(np.mean(np.square(signal))))


def draw_channel(name: str, random: np.random.Generator, pinned: Mapping[str, Any]) -> str:
    """Return the channel at fault; coupling capacitors sit in accelerometers."""
    drawn = "displacement" if random.random() < 0.4 and name != "ac_coupling" else "acceleration"
    return str(pinned.get("channel", "displacement" if name == "channel_lag" else drawn))


def error(name: str, parameters: Mapping[str, Any], signal: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return the readings that an `IMMEDIATE` fault adds to `signal` at `time` (s since the recording began)."""
    if name == "channel_gain":
        return np.asarray(parameters["error"] * signal)
    if name == "offset_drift":
        return np.asarray(parameters["rate"] * time)
    if name == "clipping":
        return np.asarray(np.clip(signal, -parameters["limit"], parameters["limit"]) - signal)
    if name == "sensor_nonlinearity":
        return np.asarray(parameters["quadratic"] * signal**2 + parameters["cubic"] * signal**3)
    if name == "mains_hum":
        angle = 2.0 * math.pi * parameters["f"] * time + parameters["phase"]
        return np.asarray(parameters["amp"] * np.sin(angle))
    raise ValueError(f"{name} is not a fault of one instant; those are: {', '.join(IMMEDIATE)}")


def filter_error(name: str, corner: float, fine: np.ndarray, interval: float) -> np.ndarray:
    """Return the readings that AC coupling or a roll-off at `corner` Hz adds, every `OVERSAMPLING` samples of `fine`.

    `fine` is the channel on a grid of `interval` s; its first value was there long before.
    """
    passed = high_pass(fine, interval, corner, fine[0])
    return np.asarray((-passed if name == "sensor_bandwidth" else passed - fine)[::OVERSAMPLING])


def size_of(
    name: str,
    strength: float,
    signal: np.ndarray,
    time: np.ndarray,
    after: np.ndarray,
    random: np.random.Generator,
    pinned: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the parameters of an `IMMEDIATE` fault at which it has this strength on `signal`.

    `after` marks the samples from the release on; values in `pinned` are kept.
    """
    size = rms(signal[after])
    side = -1.0 if random.random() < 0.5 else 1.0
    if name == "channel_gain":
        found = {"error": side * strength}
    elif name == "offset_drift":
        found = {"rate": side * strength * float(np.std(signal[after]) / np.std(time[after]))}
    elif name == "clipping":
        level = bisect(
            lambda limit: rms(error(name, {"limit": limit}, signal, time)[after]) / size,
            strength,
            float(np.max(np.abs(signal))),
            0.0,
        )
        found = {"limit": level}
    elif name == "sensor_nonlinearity":
        power, of = (2, "quadratic") if random.random() < 0.5 else (3, "cubic")
        found = {"quadratic": 0.0, "cubic": 0.0}
        found[of] = side * strength * size / rms(signal[after] ** power)
    else:
        mains = 50.0 if random.random() < 0.7 else 60.0
        found = {"amp": strength * size * math.sqrt(2.0), "f": mains + random.uniform(-0.03, 0.03)}
        found |= {"phase": random.uniform(0.0, 2.0 * math.pi)}
    return found | {key: value for key, value in pinned.items() if key in SENSOR_FAULTS[name]}


def strength_of(name: str, wrong: np.ndarray, signal: np.ndarray) -> float:
    """Return the strength of the error `wrong` on `signal`, both from the release on."""
    if name == "offset_drift":
        return float(np.std(wrong) / np.std(signal))
    return rms(wrong) / rms(signal)


def bisect(strength_at: Callable[[float], float], wanted: float, weak: float, strong: float) -> float:
    """Return the parameter between `weak` and `strong` at which the strength is met."""
    for _ in range(60):
        middle = 0.5 * (weak + strong)
        if strength_at(middle) < wanted:
            weak = middle
        else:
            strong = middle
    return 0.5 * (weak + strong)
