"""The wavelet identification: envelope and instantaneous frequency on the Morlet ridge, eqs. (5)-(12)."""

from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array, Mask, frozen, frozen_mask
from identify.averaging import backbone_factors, envelope_factors, integrate_envelope
from identify.envelope import EnvelopeFit, PhaseFit
from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.free_decay import FreeDecay
from identify.hilbert import hilbert_envelope
from identify.morlet import scalogram
from identify.noise import noise_of
from identify.orders import choose_order
from identify.oscillation import dominant_frequency
from identify.ridge_fit import (
    Observed,
    RidgeFit,
    channel_of,
    envelope_and_phase,
    exact_decay,
    first_fit,
    free_of_bias,
    noise_in_envelope,
    noise_in_phase,
    observe,
    other_backbone,
    other_order,
    parameters_of,
)
from identify.usable import first_free_sample, last_large_sample, require_cycles, valid_samples
from identify.spread import misfit_covariance
from identify.units import damping_unit, stiffness_unit

CHANNELS = ("displacement", "velocity", "acceleration")  # by number of derivatives
STIFFNESS_ORDERS = ((1,), (1, 3), (1, 3, 5))
_FEWEST_CYCLES = 3.0
_STOP_AT_DRY_ZONE = 2.5  # fit down to this many times mu_0 / w0^2, where sticking is one cycle away
_STOP_AT_NOISE = 6.0  # and to this many standard deviations of a sample


@dataclass(frozen=True, eq=False)
class WaveletResult:
    """What the envelope and the instantaneous frequency say.

    `stiffness` is K (N/m with a mass, 1/s^2 without); `damping` holds mu_i per unit mass by order
    i = 0..`order`; `stiffness_by_order` the odd orders that the backbone asks for (1; 1, 3; or 1, 3, 5).
    `mse_percent_by_order` is the misfit of the envelope for orders 0..max (fig. 3a); `reason` and
    `stiffness_reason` say why the orders were chosen. Arrays on the ridge, shape (n,): `time` (s, on the
    record's clock), `envelope`, `envelope_fit` (m), `frequency` (Hz), `trusted` (False near the ends).
    The envelope is free of the transform's own bias, at the ends too. `reconstruction` is the decay rebuilt
    from the parameters on `time`, in the unit of `channel`. `scalogram` (frequencies, times) is
    the modulus on `scalogram_frequency` (Hz) and `scalogram_time` (s). `backbone_amplitude` (m) and
    `backbone_frequency` (Hz) are the backbone, `backbone_fit` its averaged model; `hilbert_envelope` is the
    older reference on `time`. `stiffness_per_mass` (1/s^2) leaves the mass's uncertainty out.
    """

    stiffness: Estimate
    stiffness_by_order: dict[int, Estimate]
    damping: tuple[Estimate, ...]
    order: int
    reason: str
    mse_percent_by_order: tuple[float, ...]
    channel: str
    time: Array
    envelope: Array
    envelope_fit: Array
    frequency: Array
    trusted: Mask
    reconstruction: Array
    scalogram: Array
    scalogram_frequency: Array
    scalogram_time: Array
    backbone_amplitude: Array
    backbone_frequency: Array
    hilbert_envelope: Array
    backbone_fit: Array
    stiffness_per_mass: Estimate
    stiffness_reason: str


def identify_wavelet(decay: FreeDecay, max_order: int = 3) -> WaveletResult:
    """Identify stiffness and damping from the envelope and the phase of one channel.

    Displacement is used where there is one, else velocity, else acceleration. `max_order` is the highest
    order of damping that is tried, eq. (4). Raises NotIdentifiable when there is too little to identify.
    Standard errors come from the channel's noise (`noise_*`; measured on the span where unknown) carried
    through the transform, and grow with what the model leaves unexplained.
    """
    if decay.force is not None:
        raise NotIdentifiable("the record is driven by a force; the wavelet method needs a free decay")
    start, observed = _observe_span(decay)
    fit = free_of_bias(observed, first_fit(observed, min(1, max_order), (1,)), rounds=3)
    for _ in range(2):
        trials = [other_order(observed, fit, order) for order in range(max_order + 1)]
        backbones = [other_backbone(observed, fit, orders) for orders in STIFFNESS_ORDERS]
        order, reason = _choose_damping(observed, fit, trials)
        best, stiffness_reason = _choose_stiffness(observed, fit, backbones)
        fit = replace(
            fit,
            envelope_fit=trials[order],
            phase_fit=backbones[best],
            stiffness_orders=STIFFNESS_ORDERS[best],
        )
        fit = free_of_bias(observed, fit, rounds=1 if order <= 1 and best == 0 else 3)
    return _result(decay, start, observed, fit, trials, reason, stiffness_reason)


def _observe_span(decay: FreeDecay) -> tuple[int, Observed]:
    derivatives = next(i for i, name in enumerate(CHANNELS) if getattr(decay, name) is not None)
    samples = getattr(decay, CHANNELS[derivatives])
    valid = valid_samples(decay)
    whole = _interpolated(samples, valid)
    start = first_free_sample(decay)
    frequency = dominant_frequency(whole[start:], decay.rate)
    if frequency <= 0:
        raise NotIdentifiable(f"no oscillation stands out of the {CHANNELS[derivatives]} after the release")
    start = first_free_sample(decay, frequency)
    require_cycles(len(whole) - start, decay.rate, frequency, _FEWEST_CYCLES)
    noise = getattr(decay, f"noise_{CHANNELS[derivatives]}") or noise_of(decay)[CHANNELS[derivatives]].std
    noise = max(noise, 1e-9 * float(np.std(whole[start:])))

    rough = observe(whole[start:], valid[start:], decay.rate, derivatives, 2 * np.pi * frequency, noise)
    envelope, _, angular = envelope_and_phase(rough, rough.samples)
    quiet = _STOP_AT_NOISE * noise / rough.angular_frequency**derivatives
    stop = last_large_sample(envelope, max(quiet, 0.1 * float(np.max(envelope))))
    for _ in range(2):
        require_cycles(stop, decay.rate, frequency, _FEWEST_CYCLES)
        angular_frequency = float(np.median(angular[:stop]))
        part = slice(start, start + stop)
        span = observe(whole[part], valid[part], decay.rate, derivatives, angular_frequency, noise)
        fit = first_fit(span, 1, (1,))
        parameters = fit.envelope_fit.parameters
        dry = parameters[1] * np.pi / 2 / angular_frequency
        # the rough envelope is smeared where the mass sticks: read the end off the fitted one
        fitted = integrate_envelope(parameters[0], parameters[1:], 1 / decay.rate, len(envelope))
        stop = last_large_sample(fitted, max(quiet, _STOP_AT_DRY_ZONE * dry))
        stop = max(stop, min(len(envelope), int(_FEWEST_CYCLES * decay.rate / frequency) + 1))
    part = slice(start, start + stop)
    return start, observe(whole[part], valid[part], decay.rate, derivatives, angular_frequency, noise)


def _interpolated(samples: Array, valid: Mask) -> Array:
    if np.all(valid):
        return samples
    if not np.any(valid):
        raise NotIdentifiable("not a single sample of the channel is valid")
    index = np.arange(len(samples))
    return np.interp(index, index[valid], samples[valid])


def _choose_damping(observed: Observed, fit: RidgeFit, trials: list[EnvelopeFit]) -> tuple[int, str]:
    spreads = [np.sqrt(_envelope_covariance(observed, fit, trial)[-1, -1]) for trial in trials]
    clear = [abs(trial.parameters[-1]) / spread for trial, spread in zip(trials, spreads, strict=True)]
    return choose_order(range(len(trials)), [trial.mse_percent for trial in trials], clear, "damping")


def _choose_stiffness(observed: Observed, fit: RidgeFit, trials: list[PhaseFit]) -> tuple[int, str]:
    weight = np.abs(fit.envelope) * observed.weight
    misfits = [float(np.mean(((fit.phase - trial.fit) * weight) ** 2)) for trial in trials]
    spreads = [np.sqrt(_phase_covariance(observed, fit, trial)[-1, -1]) for trial in trials]
    clear = [abs(trial.parameters[-1]) / spread for trial, spread in zip(trials, spreads, strict=True)]
    order, reason = choose_order((1, 3, 5), misfits, clear, "stiffness")
    return (order - 1) // 2, reason


def _envelope_covariance(observed: Observed, fit: RidgeFit, trial: EnvelopeFit) -> Array:
    """Covariance of k(0), c_0, ...: the channel's noise, and the misfit where there is one."""
    left = fit.envelope - trial.fit
    return noise_in_envelope(observed, fit, trial.gain) + _misfit(
        observed, left, np.sqrt(observed.variance), trial.gain
    )


def _phase_covariance(observed: Observed, fit: RidgeFit, trial: PhaseFit) -> Array:
    """Covariance of phi(0), w_1, ...: the channel's noise, and the misfit where there is one."""
    amplitude = np.maximum(np.abs(fit.envelope), 1e-3 * np.max(np.abs(fit.envelope)))
    left = fit.phase - trial.fit
    return noise_in_phase(observed, fit, trial.gain) + _misfit(
        observed, left, np.sqrt(observed.variance) / amplitude, trial.gain
    )


def _misfit(observed: Observed, left: Array, spread: Array, gain: Array) -> Array:
    used = observed.weight > 0
    return misfit_covariance(left[used] / spread[used], gain[:, used] * spread[used], observed.independent)


def _result(
    decay: FreeDecay,
    start: int,
    observed: Observed,
    fit: RidgeFit,
    trials: list[EnvelopeFit],
    reason: str,
    stiffness_reason: str,
) -> WaveletResult:
    stiffness, damping = parameters_of(fit.envelope_fit, fit.phase_fit, fit.stiffness_orders)
    covariance = _envelope_covariance(observed, fit, fit.envelope_fit)
    phase_covariance = _phase_covariance(observed, fit, fit.phase_fit)
    w = fit.phase_fit.parameters[1]
    damping_std = np.sqrt(np.diag(covariance))[1:] / envelope_factors(w, fit.order)
    slopes = np.sqrt(np.diag(phase_covariance))[1:]
    factors = backbone_factors(fit.stiffness_orders)
    by_order = {
        order: Estimate(float(stiffness[order - 1]), float(2 * w * slope / factor), "")
        for order, slope, factor in zip(fit.stiffness_orders, slopes, factors, strict=True)
    }
    per_mass = replace(by_order[1], unit=stiffness_unit(1, False, decay.unit))
    with_mass = {order: _with_mass(value, order, decay) for order, value in by_order.items()}

    computed = exact_decay(observed, fit.envelope_fit, fit.phase_fit, fit.stiffness_orders)
    reconstruction = channel_of(computed, observed.derivatives)
    seen, seen_phase, seen_frequency = envelope_and_phase(observed, reconstruction)
    envelope, phase, frequency = envelope_and_phase(observed, observed.samples)
    every = np.arange(len(observed.samples))
    model = np.interp(every, observed.points, fit.envelope_fit.fit)
    averaged = sum(
        slope * model ** (order - 1)
        for order, slope in zip(fit.stiffness_orders, fit.phase_fit.parameters[1:], strict=True)
    )
    envelope = envelope - seen + model
    frequency = (frequency - seen_frequency + averaged) / (2 * np.pi)
    level = np.mean(observed.samples[observed.valid] - reconstruction[observed.valid])
    ladder = np.geomspace(0.4, 2.5, 48) * w / (2 * np.pi)
    ladder = ladder[ladder < 0.5 * observed.rate]
    coarse = max(1, int(observed.rate / (8 * ladder[-1])))
    modulus, columns = scalogram(
        _averaged(_interpolated(observed.samples, observed.valid), coarse),
        observed.rate / coarse,
        ladder,
        200,
        1.0,
    )
    time = (start + every) / decay.rate
    trusted = observed.ridge.support > 0.9
    scale = observed.angular_frequency**observed.derivatives
    return WaveletResult(
        stiffness=with_mass[1],
        stiffness_by_order=with_mass,
        damping=tuple(
            Estimate(float(value), float(std), damping_unit(i, decay.unit))
            for i, (value, std) in enumerate(zip(damping, damping_std, strict=True))
        ),
        order=fit.order,
        reason=reason,
        mse_percent_by_order=tuple(trial.mse_percent for trial in trials),
        channel=CHANNELS[observed.derivatives],
        time=frozen(time),
        envelope=frozen(envelope),
        envelope_fit=frozen(model),
        frequency=frozen(frequency),
        trusted=frozen_mask(trusted),
        reconstruction=frozen(reconstruction + level),
        scalogram=frozen(modulus),
        scalogram_frequency=frozen(ladder),
        scalogram_time=frozen(columns + time[0]),
        backbone_amplitude=frozen(envelope[trusted]),
        backbone_frequency=frozen(frequency[trusted]),
        hilbert_envelope=frozen(hilbert_envelope(observed.samples) / scale),
        backbone_fit=frozen(averaged[trusted] / (2 * np.pi)),
        stiffness_per_mass=per_mass,
        stiffness_reason=stiffness_reason,
    )


def _with_mass(value: Estimate, order: int, decay: FreeDecay) -> Estimate:
    unit = stiffness_unit(order, decay.mass is not None, decay.unit)
    if decay.mass is None:
        return replace(value, unit=unit)
    spread = np.hypot(value.std * decay.mass, value.value * (decay.mass_std or 0.0))
    return Estimate(value.value * decay.mass, float(spread), unit)


def _averaged(samples: Array, count: int) -> Array:
    whole = len(samples) // count * count
    return samples[:whole].reshape(-1, count).mean(axis=1)
