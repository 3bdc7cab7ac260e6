"""The scale of a hidden effect at which its force has the strength asked for."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping

import numpy as np

from mocks.forces import BEGINS_AT_Z, PARAMETERS, WANDERS, Effect, pulled
from mocks.sensor_faults import rms
from mocks.testbed import Bench, Release, simulate

#: Fine enough for the rms of a force that jumps.
GRID_HZ = 1024.0
#: Effects whose force may have either sign.
SIGNED = {
    "linear_stiffness",
    "cubic_stiffness",
    "quadratic_stiffness",
    "quintic_stiffness",
    "signed_quadratic_stiffness",
    "time_varying_stiffness",
    "settling_stiffness",
    "power_law_stiffness",
    "magnet",
}


def add_effects(
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
    time = np.arange(int(seconds * GRID_HZ)) / GRID_HZ
    for _ in range(80):
        effects = []
        for name, shape in shapes.items():
            main = PARAMETERS[name][0]
            value = sign[name] * scale[name] if name in searched else shape[main]
            effects.append(Effect(name, shape | {main: value}))
        hidden = Bench(bench.stiffness, bench.mu_0, bench.mu_1, tuple(effects), bench.mass)
        motion = simulate(hidden, release, time)
        total = rms(motion.acceleration)
        reached = {n: rms(f) / total for n, f in zip(strengths, motion.effects, strict=True)}
        if all(abs(reached[n] / strengths[n] - 1.0) < 1e-3 for n in searched):
            return hidden, reached
        for name in searched:
            change = strengths[name] / max(reached[name], 1e-300)
            scale[name] *= (
                change if scale[name] < 1e-4 * abs(shapes[name][PARAMETERS[name][0]]) else change**0.8
            )
    raise ValueError(f"no size of {', '.join(searched)} reaches the strength asked for on this bench")


def _draw_shape(
    name: str, displacement: float, size: float, bench: Bench, random: np.random.Generator
) -> dict[str, float]:
    """Draw what the search for the strength does not scale; the first value is its order of magnitude."""
    w = bench.angular_frequency
    side = -1.0 if random.random() < 0.5 else 1.0
    first = _magnitude(name, size, w)
    shape = {PARAMETERS[name][0]: side * first if name in SIGNED else first}
    if name in {"end_stop", "impact_with_loss"}:
        shape |= {"gap": size * random.uniform(0.5, 0.85), "side": float(random.integers(-1, 2))}
        if name == "impact_with_loss":
            shape |= {"loss": random.uniform(0.3, 0.9) / (w * size)}
    elif name == "freeplay":
        shape |= {"gap": random.uniform(0.001, 0.004)}
    elif name in BEGINS_AT_Z:
        shape |= _draw_memory(name, displacement, random)
    elif name in {"power_law_stiffness", "power_law_damping"}:
        between = random.uniform(1.4, 1.7) if random.random() < 0.5 else random.uniform(2.3, 2.7)
        shape |= {"p": between, "at": size * (1.0 if name == "power_law_stiffness" else w)}
    elif name == "settling_stiffness":
        shape |= {"tau": random.uniform(1.0, 4.0)}
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
    elif name in {"fading_friction", "fading_damping"}:
        shape |= {"tau": random.uniform(0.8, 3.0)}
    elif name in WANDERS:
        shape |= {"walk": float(random.integers(10000))}
    elif name == "adhesion":
        shape |= {"length": random.uniform(0.001, 0.003)}
    return shape


def _magnitude(name: str, size: float, w: float) -> float:
    """Return the value of an effect's first parameter that makes a force of the order of the total one."""
    force = w * w * size
    return {
        "linear_stiffness": w * w,
        "viscous_damping": w,
        "quadratic_damping": 1.0 / size,
        "cubic_damping": 1.0 / (w * size * size),
        "position_dependent_damping": w / size**2,
        "cubic_stiffness": w * w / size**2,
        "quadratic_stiffness": w * w / size,
        "quintic_stiffness": w * w / size**4,
        "signed_quadratic_stiffness": w * w / size,
        "end_stop": w * w,
        "impact_with_loss": w * w,
        "dahl_friction": w * w,
        "lugre_friction": w * w,
        "bouc_wen_hysteresis": w * w,
        "settling_stiffness": 1.0,
        "wandering_stiffness": 1.0,
        "wandering_damping": 1.0,
        "freeplay": w * w,
        "bilinear_stiffness": w * w,
        "hysteresis": w * w,
        "maxwell_element": w * w,
        "second_mass": 1.0,
        "time_varying_stiffness": 1.0,
        "amplitude_switched_damping": w,
        "fading_damping": w,
        "one_way_cable": w * w,
        "position_dependent_friction": w * w,
    }.get(name, force)


def _draw_memory(name: str, displacement: float, random: np.random.Generator) -> dict[str, float]:
    """Draw where a joint yields, or over which displacement friction gives way, and how the hold has left it."""
    if name in {"dahl_friction", "lugre_friction"}:
        over = random.uniform(0.0005, 0.003)
        shape = {"ud": over, "z_start": over if displacement > 0.0 else -over}
        if name == "lugre_friction":
            shape |= {"rise": random.uniform(0.3, 1.0), "vs": random.uniform(0.04, 0.15)}
        return shape
    yield_at = random.uniform(0.0015, 0.006)
    remembered = random.random() < 0.5
    shape = {"uy": yield_at, "z_start": pulled(displacement, yield_at) if remembered else 0.0}
    if name == "bouc_wen_hysteresis":
        shape |= {"n": random.uniform(0.7, 1.4) if random.random() < 0.5 else random.uniform(2.8, 3.5)}
    return shape
