"""Draw a release as the testbed would record it, with an effect hidden at a known strength.

Strength is the rms of the effect's acceleration over that of the total acceleration from the
release on; for a sensor's fault, the rms of the channel's error over that of the channel.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocks import sensors
from mocks.forces import OUTSIDE_THE_LIBRARY, PARAMETERS, Effect, pulled
from mocks.sensors import SENSOR_FAULTS, Sensor
from mocks.testbed import Bench, Release, simulate, simulate_channels

PHYSICS = tuple(name for name in PARAMETERS if name not in OUTSIDE_THE_LIBRARY)
#: Parameter that is scaled until the strength is met: always the first of an effect.
SIGNED = {
    "linear_stiffness",
    "cubic_stiffness",
    "quadratic_stiffness",
    "quintic_stiffness",
    "time_varying_stiffness",
    "magnet",
}
OVERSAMPLING = 16


@dataclass(frozen=True, eq=False)
class Sample:
    """A recording and its truth: `rate` Hz, `displacement` m, `acceleration` m/s^2."""

    rate: float
    displacement: np.ndarray
    acceleration: np.ndarray
    truth: dict[str, Any]


def draw(effect: str | None, strength: float | tuple[float, ...], seed: int, **fixed: Any) -> Sample:
    """Return one recorded release with `effect` hidden ("a+b" for two; None for nothing).

    `fixed` pins what is otherwise drawn: amplitude (m, signed), velocity, stiffness, mu_0, mu_1,
    lag, hand, released_at, offset_displacement, offset_acceleration, noise_displacement,
    noise_acceleration, gain_error, rate, seconds, rest, bits, range_displacement,
    range_acceleration, and `parameters` ({effect: {name: value}}; one that pins an effect's first
    parameter switches the search for its strength off). The same seed draws the same bench,
    hand, sensors and noise whatever is hidden.
    """
    names = [name.strip() for name in effect.split("+")] if effect and effect != "none" else []
    strengths = tuple(strength) if isinstance(strength, tuple | list) else (float(strength),) * len(names)
    if len(strengths) != len(names) and names:
        raise ValueError(f"{len(names)} effects need {len(names)} strengths or one, not {len(strengths)}")
    for name in names:
        if name not in PARAMETERS and name not in SENSOR_FAULTS:
            raise ValueError(f"no effect is called {name!r}; there are: {', '.join(everything())}")
    pinned: Mapping[str, Mapping[str, float]] = fixed.pop("parameters", {})
    setting = _draw_setting(seed, fixed)
    physics = {n: s for n, s in zip(names, strengths, strict=True) if n in PARAMETERS}
    faults = {n: s for n, s in zip(names, strengths, strict=True) if n in SENSOR_FAULTS}
    release = Release(setting["amplitude"], setting["velocity"], setting["hand"])
    bench = Bench(setting["stiffness"], setting["mu_0"], setting["mu_1"])
    bench, reached = hide(bench, release, physics, seed, setting["seconds"], pinned)
    displacement, acceleration, found = _record(bench, release, setting, faults, seed, pinned)
    parameters = {e.name: dict(e.parameters) for e in bench.effects} | {n: p for n, (p, _) in found.items()}
    truth = {
        "hidden": "+".join(names) if names else "none",
        "kind": _kind(names),
        "strength": strengths[0] if strengths else 0.0,
        "strengths": dict(zip(names, strengths, strict=True)),
        "strengths_reached": reached | {n: s for n, (_, s) in found.items()},
        "parameters": parameters[names[0]] if len(names) == 1 else parameters,
        "stiffness_per_mass": bench.stiffness,
        "mu_0": bench.mu_0,
        "mu_1": bench.mu_1,
        "mass_kg": bench.mass,
        "stiffness": bench.stiffness * bench.mass,
        "displacement_late_s": setting["lag"] + found.get("channel_lag", ({"lag": 0.0}, 0.0))[0]["lag"],
        "gain": 1.0 + setting["gain_error"],
        "hand_s": setting["hand"],
        "released_at_s": setting["released_at"],
        "from_m": setting["amplitude"],
        "velocity_m_s": setting["velocity"],
        "offset_m": setting["offset_displacement"],
        "offset_m_s2": setting["offset_acceleration"],
        "noise_m": setting["noise_displacement"],
        "noise_m_s2": setting["noise_acceleration"],
        "rate": setting["rate"],
        "seed": seed,
    }
    return Sample(setting["rate"], displacement, acceleration, truth)


def everything() -> tuple[str, ...]:
    """Return every name that can be hidden."""
    return (*PHYSICS, *OUTSIDE_THE_LIBRARY, *SENSOR_FAULTS)


def hide(
    bench: Bench,
    release: Release,
    strengths: Mapping[str, float],
    seed: int,
    seconds: float = 8.0,
    pinned: Mapping[str, Mapping[str, float]] | None = None,
) -> tuple[Bench, dict[str, float]]:
    """Return the bench with each effect added at its strength, and the strengths reached."""
    if not strengths:
        return bench, {}
    pinned = pinned or {}
    size = abs(release.displacement) or abs(release.velocity) / bench.angular_frequency
    shapes = {
        name: _draw_shape(
            name,
            release.displacement,
            size,
            bench,
            np.random.default_rng([seed, 2, zlib.crc32(name.encode())]),
        )
        | dict(pinned.get(name, {}))
        for name in strengths
    }
    searched = [n for n in strengths if PARAMETERS[n][0] not in pinned.get(n, {})]
    scale = {n: abs(shapes[n][PARAMETERS[n][0]]) * 1e-6 if n in searched else 1.0 for n in strengths}
    sign = {n: math.copysign(1.0, shapes[n][PARAMETERS[n][0]]) if n in searched else 1.0 for n in strengths}
    time = np.arange(int(seconds * 256.0)) / 256.0
    for _ in range(80):
        effects = []
        for name, shape in shapes.items():
            main = PARAMETERS[name][0]
            value = sign[name] * scale[name] if name in searched else shape[main]
            effects.append(Effect(name, shape | {main: value}))
        hidden = Bench(bench.stiffness, bench.mu_0, bench.mu_1, tuple(effects), bench.mass)
        motion = simulate(hidden, release, time)
        total = _rms(motion.acceleration)
        reached = {n: _rms(f) / total for n, f in zip(strengths, motion.effects, strict=True)}
        if all(abs(reached[n] / strengths[n] - 1.0) < 1e-3 for n in searched):
            return hidden, reached
        for name in searched:
            change = strengths[name] / max(reached[name], 1e-300)
            scale[name] *= (
                change if scale[name] < 1e-4 * abs(shapes[name][PARAMETERS[name][0]]) else change**0.8
            )
    raise ValueError(f"no size of {', '.join(searched)} reaches the strength asked for on this bench")


def _draw_setting(seed: int, fixed: dict[str, Any]) -> dict[str, Any]:
    random = np.random.default_rng([seed, 1])
    rest = float(fixed.get("rest", 0.75))
    rate = float(fixed.get("rate", 256.0))
    side = -1.0 if random.random() < 0.5 else 1.0
    setting: dict[str, Any] = {
        "rate": rate,
        "seconds": 8.0,
        "rest": rest,
        "stiffness": 614.0 * (1.0 + random.uniform(-0.01, 0.01)),
        "mu_0": random.uniform(0.10, 0.15),
        "mu_1": random.uniform(0.25, 0.30),
        "amplitude": side * random.uniform(0.015, 0.025),
        "velocity": 0.0,
        "lag": random.uniform(-3e-3, 3e-3),
        "hand": float(random.random() < 0.5) * random.uniform(0.002, 0.012),
        "released_at": rest + random.random() / rate,
        "offset_displacement": random.uniform(-2e-4, 2e-4),
        "offset_acceleration": random.uniform(-0.05, 0.05),
        "noise_displacement": random.uniform(3e-6, 8e-6),
        "noise_acceleration": random.uniform(0.005, 0.015),
        "gain_error": 0.0,
        "bits": 16,
        "range_displacement": 0.05,
        "range_acceleration": 50.0,
    }
    unknown = set(fixed) - set(setting)
    if unknown:
        raise TypeError(f"draw() has nothing called {', '.join(sorted(unknown))}; see its docstring")
    return setting | fixed


def _draw_shape(
    name: str, displacement: float, size: float, bench: Bench, random: np.random.Generator
) -> dict[str, float]:
    """Draw what the search for the strength does not scale; the first value is its order of magnitude."""
    w = bench.angular_frequency
    side = -1.0 if random.random() < 0.5 else 1.0
    per_force = w * w * size  # An acceleration of the order of the total one.
    first = {
        "linear_stiffness": w * w,
        "viscous_damping": w,
        "quadratic_damping": 1.0 / size,
        "cubic_damping": 1.0 / (w * size * size),
        "position_dependent_damping": w / size**2,
        "cubic_stiffness": w * w / size**2,
        "quadratic_stiffness": w * w / size,
        "quintic_stiffness": w * w / size**4,
        "end_stop": w * w,
        "freeplay": w * w,
        "bilinear_stiffness": w * w,
        "hysteresis": w * w,
        "maxwell_element": w * w,
        "second_mass": 1.0,
        "time_varying_stiffness": 1.0,
        "amplitude_switched_damping": w,
        "one_way_cable": w * w,
        "position_dependent_friction": w * w,
    }.get(name, per_force)
    shape = {PARAMETERS[name][0]: side * first if name in SIGNED else first}
    if name == "end_stop":
        shape |= {"gap": size * random.uniform(0.5, 0.85), "side": float(random.integers(-1, 2))}
    elif name == "freeplay":
        shape |= {"gap": random.uniform(0.001, 0.004)}
    elif name == "hysteresis":
        yield_at = random.uniform(0.0015, 0.006)
        remembered = random.random() < 0.5
        shape |= {"uy": yield_at, "z_start": pulled(displacement, yield_at) if remembered else 0.0}
    elif name == "maxwell_element":
        shape |= {"tau": math.exp(random.uniform(math.log(0.008), math.log(0.12)))}
    elif name == "second_mass":
        shape |= {"w2": w * random.uniform(1.5, 5.0), "zeta": random.uniform(0.005, 0.05)}
    elif name == "harmonic_forcing":
        low = random.random() < 0.15
        f = random.uniform(1.0, 3.2) if low else random.uniform(5.0, 30.0)
        shape |= {"f": f, "phase": random.uniform(0.0, 2.0 * math.pi)}
    elif name == "magnet":
        shape |= {"at": side * size * random.uniform(0.2, 0.7), "width": random.uniform(0.0015, 0.004)}
    elif name == "notched_spring":
        shape |= {"at": side * size * random.uniform(0.25, 0.65), "width": random.uniform(0.001, 0.003)}
    elif name == "amplitude_switched_damping":
        shape |= {"at": size * random.uniform(0.3, 0.6)}
    elif name == "stribeck_friction":
        shape |= {"vs": random.uniform(0.04, 0.15)}
    elif name == "fading_friction":
        shape |= {"tau": random.uniform(0.8, 3.0)}
    elif name == "adhesion":
        shape |= {"length": random.uniform(0.0005, 0.002)}
    return shape


def _record(
    bench: Bench,
    release: Release,
    setting: dict[str, Any],
    faults: Mapping[str, float],
    seed: int,
    pinned: Mapping[str, Mapping[str, float]],
) -> tuple[np.ndarray, np.ndarray, dict[str, tuple[dict[str, Any], float]]]:
    rate = setting["rate"]
    clock = np.arange(round((setting["rest"] + setting["seconds"]) * rate)) / rate - setting["released_at"]
    late = setting["lag"]
    found: dict[str, tuple[dict[str, Any], float]] = {}
    if "channel_lag" in faults:
        lag, reached = _lag_of_strength(bench, release, clock, faults["channel_lag"], seed, pinned)
        late += lag
        found["channel_lag"] = ({"lag": lag, "channel": "displacement"}, reached)
    u, a = simulate_channels(bench, release, clock - late, clock)
    truth = {"displacement": u, "acceleration": a * (1.0 + setting["gain_error"])}
    signal = dict(truth)
    after = clock >= 0.0
    for name, strength in faults.items():
        if name in {"channel_lag", "dropouts"}:
            continue
        random = np.random.default_rng([seed, 4, zlib.crc32(name.encode())])
        channel = _draw_channel(name, random, pinned)
        fine = None
        if name == "ac_coupling":
            fine = _fine(bench, release, clock, late, channel, rate) * (
                1.0 + setting["gain_error"] * (channel == "acceleration")
            )
        error, parameters = _analogue_fault(
            name,
            strength,
            signal[channel],
            clock + setting["released_at"],
            after,
            random,
            pinned.get(name, {}),
            fine,
        )
        signal[channel] = signal[channel] + error
        reached = _rms(_about_mean(error[after], name)) / _rms(_about_mean(truth[channel][after], name))
        found[name] = (parameters | {"channel": channel}, reached)
    noise = np.random.default_rng([seed, 3])
    converters = {
        "displacement": Sensor(
            setting["noise_displacement"],
            setting["bits"],
            setting["range_displacement"],
            1.0,
            setting["offset_displacement"],
        ),
        "acceleration": Sensor(
            setting["noise_acceleration"],
            setting["bits"],
            setting["range_acceleration"],
            1.0,
            setting["offset_acceleration"],
        ),
    }
    seen = {c: converters[c].convert(signal[c], noise) for c in ("displacement", "acceleration")}
    if "dropouts" in faults:
        random = np.random.default_rng([seed, 4, zlib.crc32(b"dropouts")])
        channel = _draw_channel("dropouts", random, pinned)
        kind = str(pinned.get("dropouts", {}).get("kind", "hold"))
        size = _rms(truth[channel][after]) ** 2 * after.sum()
        held, lost = sensors.hold_samples(
            seen[channel], faults["dropouts"] ** 2 * size, int(np.argmax(after)) + 1, random, kind
        )
        reached = math.sqrt(float(np.sum((held - seen[channel]) ** 2)) / size)
        seen[channel] = held
        found["dropouts"] = ({"channel": channel, "kind": kind, "lost": lost}, reached)
    for array in seen.values():
        array.setflags(write=False)
    return seen["displacement"], seen["acceleration"], found


def _analogue_fault(
    name: str,
    strength: float,
    x: np.ndarray,
    time: np.ndarray,
    after: np.ndarray,
    random: np.random.Generator,
    pinned: Mapping[str, float],
    fine: np.ndarray | None,
) -> tuple[np.ndarray, dict[str, Any]]:
    """Return the error that a sensor's fault adds to `x`, and its parameters."""
    size = _rms(x[after])
    side = -1.0 if random.random() < 0.5 else 1.0
    if name == "channel_gain":
        error = pinned.get("error", side * strength)
        return error * x, {"error": error}
    if name == "offset_drift":
        spread = _rms(_about_mean(time[after], name))
        rate = pinned.get("rate", side * strength * _rms(_about_mean(x[after], name)) / spread)
        return rate * time, {"rate": rate}
    if name == "mains_hum":
        f = pinned.get("f", 50.0 if random.random() < 0.7 else 60.0) + random.uniform(-0.03, 0.03)
        phase = pinned.get("phase", random.uniform(0.0, 2.0 * math.pi))
        amp = pinned.get("amp", strength * size * math.sqrt(2.0))
        return amp * np.sin(2.0 * math.pi * f * time + phase), {"amp": amp, "f": f, "phase": phase}
    if name == "clipping":
        limit = pinned.get("limit") or _bisect(
            lambda q: _rms((np.clip(x, -q, q) - x)[after]) / size, strength, float(np.max(np.abs(x))), 0.0
        )
        return np.clip(x, -limit, limit) - x, {"limit": limit}
    if name == "ac_coupling":
        assert fine is not None
        interval = (time[1] - time[0]) / OVERSAMPLING

        def error_of(corner: float) -> np.ndarray:
            passed = sensors.high_pass(fine, interval, corner, fine[0])[::OVERSAMPLING]
            held = fine[0]  # Held for long before: the capacitor has charged to it.
            out: np.ndarray = passed - (fine[::OVERSAMPLING] - held) - held
            return out

        corner = pinned.get("fc") or _bisect(lambda q: _rms(error_of(q)[after]) / size, strength, 1e-4, 20.0)
        return error_of(corner), {"fc": corner}
    raise ValueError(f"{name} is not an analogue fault")


def _fine(
    bench: Bench, release: Release, clock: np.ndarray, late: float, channel: str, rate: float
) -> np.ndarray:
    """Return the true channel on a grid `OVERSAMPLING` times finer."""
    shift = late if channel == "displacement" else 0.0
    dense = clock[0] - shift + np.arange(len(clock) * OVERSAMPLING) / (rate * OVERSAMPLING)
    motion = simulate(bench, release, dense)
    return motion.displacement if channel == "displacement" else motion.acceleration


def _lag_of_strength(
    bench: Bench,
    release: Release,
    clock: np.ndarray,
    strength: float,
    seed: int,
    pinned: Mapping[str, Mapping[str, float]],
) -> tuple[float, float]:
    """Return the lag whose error has this strength (rms(u') lag over rms(u) to first order)."""
    motion = simulate(bench, release, clock)
    after = clock >= 0.0
    given = pinned.get("channel_lag", {}).get("lag")
    side = -1.0 if np.random.default_rng([seed, 5]).random() < 0.5 else 1.0
    size = _rms(motion.displacement[after])
    lag = float(given) if given is not None else side * strength * size / _rms(motion.velocity[after])
    shifted = simulate(bench, release, clock - lag)
    return lag, _rms((shifted.displacement - motion.displacement)[after]) / size


def _draw_channel(name: str, random: np.random.Generator, pinned: Mapping[str, Mapping[str, float]]) -> str:
    """Draw which channel is at fault; a coupling capacitor sits in accelerometers."""
    drawn = "displacement" if random.random() < 0.4 and name != "ac_coupling" else "acceleration"
    return str(pinned.get(name, {}).get("channel", drawn))


def _kind(names: list[str]) -> str:
    kinds = {
        "sensor" if n in SENSOR_FAULTS else "outside" if n in OUTSIDE_THE_LIBRARY else "physics"
        for n in names
    }
    return "none" if not kinds else "+".join(sorted(kinds))


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def _about_mean(x: np.ndarray, name: str) -> np.ndarray:
    return x - x.mean() if name == "offset_drift" else x


def _bisect(strength_of: Any, wanted: float, weak: float, strong: float) -> float:
    """Return the parameter between `weak` and `strong` at which the strength is met."""
    for _ in range(60):
        middle = 0.5 * (weak + strong)
        if strength_of(middle) < wanted:
            weak = middle
        else:
            strong = middle
    return 0.5 * (weak + strong)
