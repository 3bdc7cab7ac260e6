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

from mocks import imperfections, sensor_faults
from mocks.bench_parameters import BenchParameters, draw_parameters
from mocks.effect_scaling import add_effects
from mocks.forces import BETWEEN_THE_NAMES, OUTSIDE_THE_LIBRARY, PARAMETERS
from mocks.sensor_faults import FILTERS, IMMEDIATE, OVERSAMPLING, SENSOR_FAULTS
from mocks.sensors import hold_samples
from mocks.testbed import Bench, simulate, simulate_channels

CHANNELS = ("displacement", "acceleration")
PHYSICS = tuple(name for name in PARAMETERS if name not in (*OUTSIDE_THE_LIBRARY, *BETWEEN_THE_NAMES))

Pinned = Mapping[str, Mapping[str, Any]]
#: name of a fault -> its parameters, and the strength that they have.
Found = dict[str, tuple[dict[str, Any], float]]


@dataclass(frozen=True, eq=False)
class Sample:
    """A recording and its truth: `rate` Hz, `displacement` m, `acceleration` m/s^2."""

    rate: float
    displacement: np.ndarray
    acceleration: np.ndarray
    truth: dict[str, Any]


def everything() -> tuple[str, ...]:
    """Return every name that can be hidden."""
    return (*PHYSICS, *OUTSIDE_THE_LIBRARY, *BETWEEN_THE_NAMES, *SENSOR_FAULTS)


def draw(effect: str | None, strength: float | tuple[float, ...], seed: int, **fixed: Any) -> Sample:
    """Return one recorded release with `effect` hidden ("a+b" for two; None for nothing).

    `fixed` pins what is otherwise drawn: any field of `BenchParameters`, and `parameters`
    ({effect: {name: value}}; one that pins an effect's first parameter switches the search for
    its strength off). The same seed draws the same bench, release, sensors and noise whatever is
    hidden. ValueError for a name that cannot be hidden or a strength that cannot be reached.
    """
    pinned: Pinned = fixed.pop("parameters", {})
    strengths = named_strengths(effect, strength)
    drawn = draw_parameters(seed, fixed)
    physics = {n: s for n, s in strengths.items() if n in PARAMETERS}
    faults = {n: s for n, s in strengths.items() if n in SENSOR_FAULTS}
    bench, reached = add_effects(drawn.bench, drawn.release, physics, seed, drawn.seconds, pinned)
    displacement, acceleration, found = _record(bench, drawn, faults, seed, pinned)
    parameters = {e.name: dict(e.parameters) for e in bench.effects} | {n: p for n, (p, _) in found.items()}
    truth = {
        "hidden": "+".join(strengths) if strengths else "none",
        "kind": kind_of(strengths),
        "strength": next(iter(strengths.values()), 0.0),
        "strengths": strengths,
        "strengths_reached": reached | {n: s for n, (_, s) in found.items()},
        "parameters": parameters[next(iter(strengths))] if len(strengths) == 1 else parameters,
        "displacement_late_s": drawn.lag
        + (found["channel_lag"][0]["lag"] if "channel_lag" in found else 0.0),
        "seed": seed,
    } | described(drawn)
    return Sample(drawn.rate, displacement, acceleration, truth)


def named_strengths(effect: str | None, strength: float | tuple[float, ...]) -> dict[str, float]:
    """Return {name: strength} of "a+b" with one strength for all or one for each."""
    names = [name.strip() for name in effect.split("+")] if effect and effect != "none" else []
    for name in names:
        if name not in PARAMETERS and name not in SENSOR_FAULTS:
            raise ValueError(f"no effect is called {name!r}; there are: {', '.join(everything())}")
    several = tuple(strength) if isinstance(strength, tuple | list) else (float(strength),) * len(names)
    if names and len(several) != len(names):
        raise ValueError(f"{len(names)} effects need {len(names)} strengths or one, not {len(several)}")
    return dict(zip(names, several, strict=False))


def kind_of(names: Mapping[str, float]) -> str:
    """Return "physics", "sensor", "outside" (the library) or "between" (its names), joined by "+", or "none"."""
    special = dict.fromkeys(SENSOR_FAULTS, "sensor")
    special |= dict.fromkeys(OUTSIDE_THE_LIBRARY, "outside") | dict.fromkeys(BETWEEN_THE_NAMES, "between")
    kinds = {special.get(n, "physics") for n in names}
    return "+".join(sorted(kinds)) or "none"


def described(drawn: BenchParameters) -> dict[str, Any]:
    """Return the true values of drawn parameters under the names of a truth file."""
    return {
        "stiffness_per_mass": drawn.stiffness,
        "stiffness": drawn.stiffness * drawn.bench.mass,
        "mu_0": drawn.mu_0,
        "mu_1": drawn.mu_1,
        "mass_kg": drawn.bench.mass,
        "gain": 1.0 + drawn.gain_error,
        "hand_s": drawn.release_time,
        "released_at_s": drawn.released_at,
        "from_m": drawn.amplitude,
        "velocity_m_s": drawn.velocity,
        "offset_m": drawn.offset_displacement,
        "offset_m_s2": drawn.offset_acceleration,
        "noise_m": drawn.noise_displacement,
        "noise_m_s2": drawn.noise_acceleration,
        "rate": drawn.rate,
    }


def find_faults(
    bench: Bench, drawn: BenchParameters, faults: Mapping[str, float], seed: int, pinned: Pinned
) -> tuple[dict[str, np.ndarray], Found]:
    """Return both channels before noise and converter, faults included, and what the faults are."""
    clock = np.arange(round((drawn.rest + drawn.seconds) * drawn.rate)) / drawn.rate
    since = clock - drawn.released_at
    after = since >= 0.0
    late = drawn.lag
    found: Found = {}
    if "channel_lag" in faults:
        lag, reached = _find_lag(bench, drawn, since, faults["channel_lag"], seed, pinned)
        late += lag
        found["channel_lag"] = ({"lag": lag, "channel": "displacement"}, reached)
    u, a = simulate_channels(bench, drawn.release, since - late, since)
    gains = {channel: drawn.sensors[channel].gain for channel in CHANNELS}
    clean = {"displacement": u * gains["displacement"], "acceleration": a * gains["acceleration"]}
    signal = dict(clean)
    for name in (n for n in faults if n in (*IMMEDIATE, *FILTERS)):
        random = _random(seed, name)
        fixed = pinned.get(name, {})
        channel = sensor_faults.draw_channel(name, random, fixed)
        if name in FILTERS:
            fine = gains[channel] * _fine(bench, drawn, since, late, channel)
            corner, wrong = _find_corner(name, faults[name], fine, drawn.rate, after, fixed)
            parameters: dict[str, Any] = {"fc": corner}
        else:
            parameters = sensor_faults.size_of(
                name, faults[name], signal[channel], clock, after, random, fixed
            )
            wrong = sensor_faults.error(name, parameters, signal[channel], clock)
        signal[channel] = signal[channel] + wrong
        reached = sensor_faults.strength_of(name, wrong[after], clean[channel][after])
        found[name] = (parameters | {"channel": channel}, reached)
    return signal, found


def _record(
    bench: Bench, drawn: BenchParameters, faults: Mapping[str, float], seed: int, pinned: Pinned
) -> tuple[np.ndarray, np.ndarray, Found]:
    signal, found = find_faults(bench, drawn, faults, seed, pinned)
    noise = np.random.default_rng([seed, 3])
    if drawn.imperfections:
        signal = _with_imperfections(bench, drawn, signal, seed)
    seen = {c: drawn.sensors[c].convert(signal[c] / drawn.sensors[c].gain, noise) for c in CHANNELS}
    if "dropouts" in faults:
        found["dropouts"] = _drop(signal, seen, drawn, faults["dropouts"], seed, pinned.get("dropouts", {}))
    for array in seen.values():
        array.setflags(write=False)
    return seen["displacement"], seen["acceleration"], found


def _with_imperfections(
    bench: Bench, drawn: BenchParameters, signal: Mapping[str, np.ndarray], seed: int
) -> dict[str, np.ndarray]:
    names, fine = drawn.imperfections, {}
    n = len(signal["displacement"])
    if imperfections.BANDWIDTH in names:
        since = np.arange(n) / drawn.rate - drawn.released_at
        fine["displacement"] = _fine(bench, drawn, since, drawn.lag, "displacement")
    seen = imperfections.distorted(names, signal, fine, OVERSAMPLING)
    white = {"displacement": drawn.noise_displacement, "acceleration": drawn.noise_acceleration}
    pair = seed if drawn.sensor_pair is None else drawn.sensor_pair
    return {
        c: seen[c] + white[c] * imperfections.noise_of(names, c, n, seed, CHANNELS, pair) for c in CHANNELS
    }


def find_dropouts(
    bench: Bench, drawn: BenchParameters, strength: float, seed: int
) -> tuple[dict[str, Any], float]:
    """Return drop-outs of this strength on a recording of `drawn`, and the strength reached."""
    signal, _ = find_faults(bench, drawn, {}, seed, {})
    return _drop(signal, dict(signal), drawn, strength, seed, {})


def _drop(
    signal: dict[str, np.ndarray],
    seen: dict[str, np.ndarray],
    drawn: BenchParameters,
    strength: float,
    seed: int,
    pinned: Mapping[str, Any],
) -> tuple[dict[str, Any], float]:
    """Lose samples of one channel of `seen`, in place; return which, and the strength reached."""
    random = _random(seed, "dropouts")
    channel = sensor_faults.draw_channel("dropouts", random, pinned)
    kind = str(pinned.get("kind", "hold"))
    first = math.ceil(drawn.released_at * drawn.rate)
    size = float(np.sum(signal[channel][first:] ** 2))
    held, lost = hold_samples(seen[channel], strength**2 * size, first + 1, random, kind)
    reached = math.sqrt(float(np.sum((held - seen[channel]) ** 2)) / size)
    seen[channel] = held
    return {"channel": channel, "kind": kind, "lost": lost}, reached


def _random(seed: int, name: str) -> np.random.Generator:
    return np.random.default_rng([seed, 4, zlib.crc32(name.encode())])


def _find_lag(
    bench: Bench, drawn: BenchParameters, since: np.ndarray, strength: float, seed: int, pinned: Pinned
) -> tuple[float, float]:
    """Return the lag whose error has this strength: rms(u') lag over rms(u), to first order."""
    motion = simulate(bench, drawn.release, since)
    after = since >= 0.0
    given = pinned.get("channel_lag", {}).get("lag")
    side = -1.0 if np.random.default_rng([seed, 5]).random() < 0.5 else 1.0
    size = float(np.sqrt(np.mean(motion.displacement[after] ** 2) / np.mean(motion.velocity[after] ** 2)))
    lag = float(given) if given is not None else side * strength * size
    wrong = simulate(bench, drawn.release, since - lag).displacement - motion.displacement
    return lag, sensor_faults.strength_of("channel_lag", wrong[after], motion.displacement[after])


def _fine(bench: Bench, drawn: BenchParameters, since: np.ndarray, late: float, channel: str) -> np.ndarray:
    """Return the true channel on a grid `OVERSAMPLING` times finer."""
    shift = late if channel == "displacement" else 0.0
    steps = np.arange(len(since) * OVERSAMPLING) / (drawn.rate * OVERSAMPLING)
    motion = simulate(bench, drawn.release, since[0] - shift + steps)
    return motion.displacement if channel == "displacement" else motion.acceleration


def _find_corner(
    name: str, strength: float, fine: np.ndarray, rate: float, after: np.ndarray, pinned: Mapping[str, Any]
) -> tuple[float, np.ndarray]:
    """Return the corner (Hz) at which a filter has this strength, and its error."""
    interval = 1.0 / (rate * OVERSAMPLING)
    signal = fine[::OVERSAMPLING][after]

    def strength_at(corner: float) -> float:
        wrong = sensor_faults.filter_error(name, corner, fine, interval)[after]
        return sensor_faults.strength_of(name, wrong, signal)

    corner = float(pinned.get("fc") or sensor_faults.bisect(strength_at, strength, *FILTERS[name]))
    return corner, sensor_faults.filter_error(name, corner, fine, interval)
