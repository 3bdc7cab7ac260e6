"""The wavelet identification: envelope and instantaneous frequency on the Morlet ridge, eqs. (5)-(12)."""

from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array, Mask, frozen, frozen_mask
from identify.clock_error import clock_sentence
from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.free_decay import CHANNELS, FreeDecay
from identify.identified import Identified, dampings, stiffnesses, with_mass
from identify.preprocessing.aligned_decay import AlignedDecay, aligned
from identify.preprocessing.motion import reconstruct
from identify.preprocessing.noise import noise_levels
from identify.preprocessing.sampling import block_averaged, block_means
from identify.preprocessing.usable import usable
from identify.signal.averaging import backbone_factors, envelope_factors
from identify.signal.fractional_delay import bridge
from identify.signal.morlet import scalogram
from identify.signal.order_selection import CLEAR, choose_order
from identify.summary import Summary
from identify.wavelet.envelope import EnvelopeFit, PhaseFit
from identify.wavelet.free_of_bias import free_of_bias
from identify.wavelet.ridge_fit import (
    Observed,
    RidgeFit,
    RunsAway,
    exact_decay,
    first_fit,
    observe,
    other_backbone,
    other_order,
    parameters_of,
)
from identify.wavelet.ridge_spread import clearances_of, spreads_of

STIFFNESS_ORDERS = ((1,), (1, 3), (1, 3, 5))
_FEWEST_CYCLES = 3.0
_CHANGES_OF_MODEL = 5  # the orders may be chosen again once the chosen model's bias has been taken off
_FALL = 0.85  # of the lower order's misfit, where the higher one leaves hardly more than noise
_KNEE = 0.3  # where it leaves more than noise: the knee of fig. 3
_SHOWN = 0.1  # where it leaves so little, the order is there, however uncertain its size
_TRUSTED = 0.9  # share of the window that must hold samples


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class WaveletResult(Identified):
    """The result from the envelope and the instantaneous frequency.

    `stiffness_by_order` holds the odd orders that the backbone asks for (1; 1, 3; or 1, 3, 5), and
    `stiffness_reason` says why; `mse_percent_by_order` is the misfit of the envelope.
    Arrays on the ridge, shape (n,): `time` (s, on the
    record's clock), `envelope`, `envelope_fit` (m), `frequency`, `frequency_fit` (Hz), `trusted` (False near the ends).
    The envelope is free of the transform's own bias, at the ends too. `reconstruction` is the decay rebuilt
    from the parameters on `time`, in the unit of `channel`. `scalogram` (frequencies, times) is
    the modulus on `scalogram_frequency` (Hz) and `scalogram_time` (s).
    """

    channel: str
    time: Array
    envelope: Array
    envelope_fit: Array
    frequency: Array
    frequency_fit: Array
    trusted: Mask
    reconstruction: Array
    scalogram: Array
    scalogram_frequency: Array
    scalogram_time: Array
    stiffness_reason: str
    clock: str = ""

    def brief(self) -> Summary:
        """Return the coefficients with their errors, and why these orders were chosen."""
        reasons = (f"{self.reason}.", f"{self.stiffness_reason}.", self.clock)
        return Summary("Wavelet envelope and phase", reasons, ("coefficient", "value"), self.rows)


def identify_wavelet(
    decay: FreeDecay | AlignedDecay,
    max_order: int = 3,
    stiffness_orders: tuple[int, ...] = (1,),
    least_order: int = 0,
) -> WaveletResult:
    """Identify stiffness and damping from the envelope and the phase of one channel.

    A decay that has not been located is located and aligned first. Displacement is used where there is one, else
    velocity, else acceleration. `max_order` is the highest
    order of damping that is tried, eq. (4), `least_order` the lowest; the backbone has at least the odd `stiffness_orders`,
    as far as it can. Raises NotIdentifiable when there is too little to identify.
    Where viscous damping was tried and is not there, the error of dry friction is that beside it.
    Standard errors come from the channel's noise (`noise_*`; measured on the window where unknown) carried
    through the transform, and grow with what the model leaves unexplained.
    """
    decay, begins = block_averaged(aligned(decay))
    start, observed = _observed(decay)
    fit = _begun(observed, min(1, max_order))
    wanted = {1, *stiffness_orders} & set(STIFFNESS_ORDERS[-1])
    tried = tuple(orders for orders in STIFFNESS_ORDERS if wanted <= set(orders))
    fit, misfits, reasons = _with_orders(observed, fit, (least_order, max_order), tried)
    begins += start / decay.rate
    return _result(decay, begins, observed, fit, misfits, reasons, viscous=max_order > 0)


def _observed(decay: FreeDecay) -> tuple[int, Observed]:
    """Return the first usable sample of the lowest channel, and its ridge over what is usable; no other one is asked."""
    if decay.driven:
        raise NotIdentifiable(
            "a force drives the motion to the end of the record; the wavelet method needs a free decay"
        )
    (channel, samples), *others = decay.channels.items()
    alone = decay.with_(force=None, **{name: None for name, _ in others})
    valid = alone.known
    noise, motion = noise_levels(alone)[channel], reconstruct(alone)
    first, stop, w = usable(alone, motion, {channel: noise}, _FEWEST_CYCLES)
    part = slice(motion.start + first, motion.start + stop)
    whole, derivatives = bridge(samples, valid), CHANNELS.index(channel)
    return part.start, observe(whole[part], valid[part], decay.rate, derivatives, w, noise)


def _begun(observed: Observed, order: int) -> RidgeFit:
    """Fit damping of this order and a cubic spring, or a linear one where with a cubic one the motion would run away.

    A cubic spring that is left out bends the phase, and passes for damping of high order; one too many is dropped later.
    """
    try:
        return free_of_bias(observed, first_fit(observed, order, (1, 3)))
    except RunsAway:
        return free_of_bias(observed, first_fit(observed, order, (1,)))


def _with_orders(
    observed: Observed,
    begun: RidgeFit,
    damping: tuple[int, int],
    tried: tuple[tuple[int, ...], ...],
    higher: str = "no higher order was tried",
) -> tuple[RidgeFit, tuple[float, ...], tuple[str, str]]:
    """Return the fit with the orders that it asks for, the misfit of every damping order, and why they were chosen.

    `damping` is the lowest and the highest order of damping, `tried` are sets of orders of the backbone. Stiffness is chosen
    before damping. Orders with which the motion would diverge are not tried again: first those of stiffness, then those of
    damping; nor is an order of stiffness that is not clear of zero once its bias is off, unless the misfit shows that it is
    there. `higher` says why none above these is.
    """
    least, most = damping
    fit = begun
    for _ in range(_CHANGES_OF_MODEL):
        trials = [other_order(observed, fit, order) for order in range(most + 1)]
        backbones = [other_backbone(observed, fit, orders) for orders in tried]
        order, reason = _choose_damping(observed, fit, trials, least)
        best, stiffness_reason, misfits = _choose_stiffness(observed, fit, backbones, tried, higher)
        if tried[best] != fit.stiffness_orders:
            changed = replace(fit, phase_fit=backbones[best], stiffness_orders=tried[best])
        elif order != fit.order:
            changed = replace(fit, envelope_fit=trials[order])
        else:
            break
        try:
            fit = free_of_bias(observed, changed)
        except RunsAway:
            if best:
                return _with_orders(
                    observed, begun, damping, tried[:best], "with a higher one the motion would diverge"
                )
            if order > least:
                return _with_orders(observed, begun, (least, order - 1), tried, higher)
            raise
    at, away = tried.index(fit.stiffness_orders), np.inf
    if at and misfits[at] > _SHOWN * min(misfits[:at]):
        away = abs(fit.phase_fit.parameters[-1]) / spreads_of(observed, fit)[1][-1]
    if away < CLEAR:
        far = f"the coefficient of order {tried[at][-1]} would be only {away:.1f} standard errors from zero"
        return _with_orders(observed, begun, damping, tried[:at], far)
    return fit, tuple(trial.mse_percent for trial in trials), (reason, stiffness_reason)


def _choose_damping(
    observed: Observed, fit: RidgeFit, trials: list[EnvelopeFit], least: int
) -> tuple[int, str]:
    clear = clearances_of(observed, fit, trials, phase=False)
    noise = 100 * float(np.mean(observed.variance) / np.var(fit.envelope))
    misfits = [trial.mse_percent for trial in trials]
    worth = _worth(misfits, noise)
    return choose_order(range(least, len(trials)), misfits[least:], clear[least:], worth[least:], "damping")


def _choose_stiffness(
    observed: Observed,
    fit: RidgeFit,
    trials: list[PhaseFit],
    tried: tuple[tuple[int, ...], ...],
    higher: str,
) -> tuple[int, str, list[float]]:
    weight = np.abs(fit.envelope) * observed.weight
    misfits = [float(np.mean(((fit.phase - trial.fit) * weight) ** 2)) for trial in trials]
    clear = clearances_of(observed, fit, trials, phase=True)
    noise = float(np.mean(observed.variance * observed.weight**2))
    highest = [orders[-1] for orders in tried]
    order, reason = choose_order(highest, misfits, clear, _worth(misfits, noise), "stiffness", higher)
    return highest.index(order), reason, misfits


def _worth(misfits: list[float], noise: float) -> list[float]:
    """The fall of the misfit that pays for an order: a little where it comes down to the noise, else a knee."""
    return [_FALL if misfit < 2 * noise else _KNEE for misfit in misfits]


def _result(
    decay: FreeDecay,
    begins: float,
    observed: Observed,
    fit: RidgeFit,
    misfits: tuple[float, ...],
    reasons: tuple[str, str],
    *,
    viscous: bool,
) -> WaveletResult:
    per_mass, damping = _estimates(decay, observed, fit, viscous=viscous)
    stiffness = with_mass(decay, per_mass)
    reconstruction = exact_decay(observed, fit)
    level = np.mean(observed.samples[observed.valid] - reconstruction[observed.valid])
    time = begins + np.arange(len(observed.samples)) / decay.rate
    ridge = _curves(observed, fit, reconstruction)
    modulus, ladder, columns = _scalogram(observed)
    return WaveletResult(
        stiffness_by_order=stiffness,
        damping=damping,
        order=fit.order,
        reason=reasons[0],
        mse_percent_by_order=misfits,
        channel=CHANNELS[observed.derivatives],
        time=frozen(time),
        envelope=frozen(ridge["envelope"]),
        envelope_fit=frozen(ridge["model"]),
        frequency=frozen(ridge["frequency"]),
        frequency_fit=frozen(ridge["averaged"]),
        trusted=frozen_mask(ridge["support"] > _TRUSTED),
        reconstruction=frozen(reconstruction + level),
        scalogram=frozen(modulus),
        scalogram_frequency=frozen(ladder),
        scalogram_time=frozen(columns + time[0]),
        stiffness_per_mass=per_mass[1],
        stiffness_reason=reasons[1],
        clock=clock_sentence(next(iter(stiffness.values())), decay.rate, decay.rate_std),
    )


def _estimates(
    decay: FreeDecay, observed: Observed, fit: RidgeFit, *, viscous: bool
) -> tuple[dict[int, Estimate], tuple[Estimate, ...]]:
    """Stiffness per unit mass by order, and damping, with their standard errors.

    Where there may be `viscous` damping, dry friction alone has the error that it has beside it, and what that would change.
    """
    stiffness, damping = parameters_of(fit)
    w = fit.phase_fit.parameters[1]
    of_envelope, of_phase = spreads_of(observed, fit)
    damping_std = of_envelope[1:] / envelope_factors(w, fit.order)
    stiffness_std = 2 * w * of_phase[1:] / backbone_factors(fit.stiffness_orders)
    if fit.order == 0 and viscous:
        usual = replace(fit, envelope_fit=other_order(observed, fit, 1), ahead=None)
        try:
            of_usual = spreads_of(observed, usual)[0][1:2] / envelope_factors(w, 0)
        except RunsAway:
            of_usual = np.array([np.inf])
        damping_std = np.hypot(of_usual, parameters_of(usual)[1][:1] - damping)
    by_order = {i: (stiffness[i], std) for i, std in zip(fit.stiffness_orders, stiffness_std, strict=True)}
    return stiffnesses(decay, by_order), dampings(decay, zip(damping, damping_std, strict=True))


def _curves(observed: Observed, fit: RidgeFit, reconstruction: Array) -> dict[str, Array]:
    """Envelope and frequency (Hz) freed of bias, and their models, at every sample: model plus what it leaves."""
    every, points = np.arange(len(observed.samples)), observed.points
    model = np.interp(every, points, fit.envelope_fit.fit)
    averaged = np.zeros(len(every))
    for order, slope in zip(fit.stiffness_orders, fit.phase_fit.parameters[1:], strict=True):
        averaged += slope * model ** (order - 1) / (2 * np.pi)
    measured, _, frequency = observed.measured
    seen, _, seen_frequency = observed.seen(reconstruction)
    beyond = (frequency - seen_frequency) / (2 * np.pi)
    return {
        "envelope": model + np.interp(every, points, measured - seen),
        "model": model,
        "frequency": averaged + np.interp(every, points, beyond),
        "averaged": averaged,
        "support": np.interp(every, points, observed.ridge.support),
    }


def _scalogram(observed: Observed) -> tuple[Array, Array, Array]:
    ladder = np.geomspace(0.4, 2.5, 40) * observed.angular_frequency / (2 * np.pi)
    ladder = ladder[ladder < 0.5 * observed.rate]
    coarse = max(1, int(observed.rate / (6 * ladder[-1])))
    averaged = block_means(bridge(observed.samples, observed.valid), coarse)
    modulus, columns = scalogram(averaged, observed.rate / coarse, ladder)
    return modulus, ladder, columns
