"""The setting of a fit: the spans that are compared, the motion they show, and where to begin."""

from dataclasses import dataclass

import numpy as np

from identify.alignment import Alignment, align, correct
from identify.arrays import Array
from identify.effects.effect import Scales
from identify.equation_error import Regression, force_along, moving, regress
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.model import Model, Term
from identify.motion import Motion, reconstruct
from identify.noise import noise_of
from identify.problem import LINEAR
from identify.release import Release
from identify.span import CHANNELS, Span

_SHORTEST_CYCLES = 4.0
_LAG_REACH = 0.06


@dataclass(frozen=True, eq=False)
class Setting:
    """One release made ready to be fitted.

    `span` holds the readings, `motion` the displacement (from the spring's zero), velocity and acceleration along
    it, on the acceleration's clock; `frequency` is the angular frequency (rad/s); `alignment` is None with one channel.
    """

    span: Span
    motion: Motion
    frequency: float
    alignment: Alignment | None
    zero: float

    @property
    def time(self) -> Array:
        """Time since the release of each sample of the motion, s."""
        return self.span.time + np.arange(len(self.motion.displacement)) / self.span.rate

    @property
    def amplitude(self) -> float:
        """Largest displacement from zero, in the unit of the displacement."""
        return float(np.max(np.abs(self.motion.displacement)))


def prepare(decay: FreeDecay, release: Release, *, gain_uncertainty: float = 0.0) -> Setting:
    """Make one release ready: align, reconstruct the motion, cut the record where friction takes over.

    Raises NotIdentifiable when fewer than four cycles remain.
    """
    noise = {name: found.std for name, found in noise_of(decay).items()}
    decay = decay.with_(**{f"noise_{name}": max(std, 1e-300) for name, std in noise.items()})
    alignment = _align(decay)
    corrected = correct(decay, alignment) if alignment is not None else decay
    free = corrected.with_(release=release.settle)
    motion = reconstruct(free)
    motion = _cut(motion, max(release.end - release.settle, 0))
    if len(motion.displacement) < 16:
        raise NotIdentifiable("The motion after the release is too short; record at least four cycles.")
    base = regress(motion, _base_columns(motion), moving(motion))
    k, mu_1, mu_0 = base.strengths
    if not k > 0.0:
        raise NotIdentifiable("The motion shows no restoring force: is the displacement's sign reversed?")
    frequency = float(np.sqrt(k))
    zero = -base.constant / k
    length = _length(motion, zero, frequency, max(mu_0, 0.0) / k, noise)
    if length * frequency / (2.0 * np.pi * decay.rate) < _SHORTEST_CYCLES:
        raise NotIdentifiable(
            f"Only {length * frequency / (2.0 * np.pi * decay.rate):.1f} cycles of free motion stand above friction "
            "and noise; record at least four, from a larger release."
        )
    motion = _cut(motion, length)
    motion = _shifted(motion, zero)
    return Setting(
        _span(decay, release, motion, frequency, noise, alignment, gain_uncertainty),
        motion,
        frequency,
        alignment,
        zero,
    )


def starting_values(
    setting: Setting, model: Model, inner: dict[str, float], tag: str = ""
) -> dict[str, float]:
    """Return where a fit may begin: strengths by equation error, the state from the motion, by unknown's name.

    `inner` gives inner parameters by "effect.parameter". `tag` marks the span when there are several.
    """
    terms = [t for t in model.terms if t.effect.kind == "physics"]
    found = regress_model(setting, model, inner)
    values = dict(inner)
    for term, strength in zip(terms, found.strengths, strict=True):
        parameter = term.effect.strength
        values[f"{term.effect.name}.{parameter.name}"] = float(
            np.clip(strength, parameter.low, parameter.high)
        )
    motion, span = setting.motion, setting.span
    u, v = float(motion.displacement[0]), float(motion.velocity[0])
    values[f"displacement{tag}"] = u
    values[f"velocity{tag}"] = v
    for term in terms:
        if term.effect.rest is not None:
            p = np.array(
                [0.0]
                + [
                    float(term.held[q.name]) if q.name in term.held else inner[f"{term.effect.name}.{q.name}"]
                    for q in term.effect.parameters[1:]
                ]
            )
            rest = term.effect.rest(u, p)
            values[f"{term.effect.name}.state0{tag}"] = rest[0]
            if term.effect.states > 1:
                values[f"{term.effect.name}.state1{tag}"] = v if rest[1] == 0.0 else rest[1]
    values[f"lag{tag}"] = span.lag
    values[f"gain{tag}"] = setting.alignment.gain.value if setting.alignment is not None else 1.0
    if "displacement" in span.readings:
        values[f"displacement_offset{tag}"] = setting.zero
    if "acceleration" in span.readings:
        used = span.used["acceleration"]
        values[f"acceleration_offset{tag}"] = float(
            np.median((span.readings["acceleration"] - values[f"gain{tag}"] * motion.acceleration)[used])
        )
    return values


def regress_model(setting: Setting, model: Model, inner: dict[str, float]) -> Regression:
    """Regress the measured acceleration on the forces of a model at given inner parameters."""
    motion = setting.motion
    borrowed = {"linear_stiffness.k": setting.frequency**2}
    columns = []
    for term in model.terms:
        effect = term.effect
        if effect.kind != "physics":
            continue
        values = {
            p.name: inner[f"{effect.name}.{p.name}"]
            for p in effect.parameters[1:]
            if p.name not in term.held and effect.name not in LINEAR
        }
        columns.append(
            force_along(term, values, setting.time, motion.displacement, motion.velocity, borrowed)
        )
    return regress(motion, np.column_stack(columns), moving(motion), motion.noise_acceleration or 1.0)


def scales_of(setting: Setting, lines: dict[str, tuple[tuple[float, float, float], ...]]) -> Scales:
    """Return the sizes from which effects take their starting values."""
    span = setting.span
    return Scales(
        amplitude=setting.amplitude,
        frequency=setting.frequency,
        duration=len(span) / span.rate,
        rate=span.rate,
        peaks={c: float(np.max(np.abs(span.readings[c][span.used[c]]))) for c in span.channels},
        lines=lines,
    )


def term_starts(term: Term, scales: Scales) -> tuple[dict[str, float], ...]:
    """Return the starting values of a term's inner parameters, by "effect.parameter"."""
    effect = term.effect
    if effect.kind == "sensor":
        if term.channel not in scales.peaks:
            return ()
        starts = effect.sensor_starts(scales, term.channel)
        return tuple(
            {f"{effect.name}.{p.name}": v for p, v in zip(effect.parameters, s, strict=True)} for s in starts
        )
    inner = [p for p in effect.parameters[1:] if p.name not in term.held]
    return tuple(
        {f"{effect.name}.{p.name}": v for p, v in zip(inner, start, strict=True)}
        for start in effect.starts(scales)
    )


def _align(decay: FreeDecay) -> Alignment | None:
    if decay.acceleration is None or (decay.displacement is None and decay.velocity is None):
        return None
    try:
        return align(decay)
    except NotIdentifiable:
        return None


def _cut(motion: Motion, samples: int) -> Motion:
    return Motion(
        motion.rate,
        motion.start,
        motion.displacement[:samples],
        motion.velocity[:samples],
        motion.acceleration[:samples],
        motion.valid[:samples],
        motion.source,
        motion.noise_velocity,
        motion.noise_acceleration,
    )


def _shifted(motion: Motion, zero: float) -> Motion:
    return Motion(
        motion.rate,
        motion.start,
        motion.displacement - zero,
        motion.velocity,
        motion.acceleration,
        motion.valid,
        motion.source,
        motion.noise_velocity,
        motion.noise_acceleration,
    )


def _base_columns(motion: Motion) -> Array:
    return np.column_stack([motion.displacement, motion.velocity, np.sign(motion.velocity)])


def _length(motion: Motion, zero: float, frequency: float, stuck: float, noise: dict[str, float]) -> int:
    """Number of samples until the amplitude falls to a few times the band in which the mass can stick, or the noise."""
    amplitude = np.hypot(motion.displacement - zero, motion.velocity / frequency)
    floors = [noise["displacement"]] if "displacement" in noise else []
    floors += [noise["velocity"] / frequency] if "velocity" in noise else []
    floors += [noise["acceleration"] / frequency**2] if "acceleration" in noise else []
    limit = 3.0 * stuck + 8.0 * min(floors)
    above = np.flatnonzero(amplitude > limit)
    return int(above[-1]) + 1 if len(above) else 0


def _span(
    decay: FreeDecay,
    release: Release,
    motion: Motion,
    frequency: float,
    noise: dict[str, float],
    alignment: Alignment | None,
    gain_uncertainty: float,
) -> Span:
    start, length = release.settle, len(motion.displacement)
    valid = np.ones(len(decay), dtype=bool) if decay.valid is None else np.asarray(decay.valid)
    lag = alignment.lag.value if alignment is not None else 0.0
    reach = _LAG_REACH * 2.0 * np.pi / frequency
    lead = int(np.ceil((abs(lag) + 0.2 * reach) * decay.rate)) + 1 if alignment is not None else 1
    part = slice(start, start + length)
    readings, used = {}, {}
    for channel in CHANNELS:
        values = getattr(decay, channel)
        if values is not None:
            readings[channel] = values[part]
            mask = valid[part].copy()
            mask[:lead] = False
            used[channel] = mask
    return Span(
        rate=decay.rate,
        time=(start - release.time_s * decay.rate) / decay.rate,
        readings=readings,
        used=used,
        sigma={c: noise[c] for c in readings},
        lead=lead,
        lag=lag,
        lag_reach=reach,
        gain_uncertainty=gain_uncertainty,
        force=None if decay.force is None else decay.force[part],
        unit=decay.unit,
    )
