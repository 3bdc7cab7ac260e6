"""The wavelet identification: envelope and instantaneous frequency on the Morlet ridge, eqs. (5)-(12)."""

from dataclasses import dataclass
from math import sqrt

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
from identify.signal.fractional_delay import bridge
from identify.signal.morlet import scalogram
from identify.signal.order_selection import choose_order
from identify.summary import Summary
from identify.wavelet.exact_fit import Orders, RidgeFit, fit_exactly
from identify.wavelet.ridge import Observed, RunsAway, exact_decay, observe

STIFFNESS_ORDERS = ((1,), (1, 3), (1, 3, 5))
_FEWEST_CYCLES = 3.0
_NOISE = 2.0  # mean square that is left, in units of the noise, up to which a fit is not tried again
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
    wanted = {1, *stiffness_orders} & set(STIFFNESS_ORDERS[-1])
    tried = tuple(orders for orders in STIFFNESS_ORDERS if wanted <= set(orders))
    fit, known, reasons = _fits(observed, (least_order, max_order), tried)
    by_order = [known[order, fit.orders] for order in range(max_order + 1)]
    return _result(decay, begins + start / decay.rate, observed, fit, by_order, reasons)


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


def _fits(
    observed: Observed, damping: tuple[int, int], tried: tuple[tuple[int, ...], ...]
) -> tuple[RidgeFit, dict[Orders, RidgeFit | None], tuple[str, str]]:
    """Return the fit with the orders that the ridge asks for, all that were tried, and why these were chosen.

    `damping` is the lowest and the highest order of damping, `tried` are sets of orders of the backbone. Each is chosen
    beside the other, in turn, until neither changes. None is the fit of a model with which the motion diverges; RunsAway
    where it does with all.
    """
    least, most = damping
    known: dict[Orders, RidgeFit | None] = {}

    def fitted(models: list[Orders], envelope: Array, phase: Array) -> list[RidgeFit]:
        for model in models:
            before = known.get(model)
            if before is None or before.misfit > _NOISE:  # a start nearer by may lead out of a false minimum
                again = fit_exactly(observed, *model, envelope, phase)
                if before is None or (again is not None and again.misfit < _SHOWN * before.misfit):
                    known[model] = again
        return [fit for model in models if (fit := known[model])]

    # A cubic spring that is left out bends the phase, and passes for damping of high order; one too many is dropped.
    begun = fitted([(min(1, most), (1, 3)), (min(1, most), (1,))], *observed.measured[:2])
    if not begun:
        raise RunsAway
    fit, visited = begun[0], set[RidgeFit]()
    while fit not in visited:
        visited.add(fit)
        backbones = fitted([(fit.order, orders) for orders in tried], fit.envelope, fit.phase)
        fit, of_stiffness = _chosen(backbones, "stiffness", tried[-1][-1], observed.independent)
        trials = fitted([(order, fit.orders) for order in range(most + 1)], fit.envelope, fit.phase)
        fit, of_damping = _chosen(
            [one for one in trials if one.order >= least], "damping", most, observed.independent
        )
    return fit, known, (of_damping, of_stiffness)


def _chosen(fits: list[RidgeFit], what: str, most: int, independent: float) -> tuple[RidgeFit, str]:
    """Choose among fits of ascending orders of stiffness, or of damping, up to `most`; RunsAway where there are none."""
    if not fits:
        raise RunsAway
    last = -1 if what == "stiffness" else -2 - len(fits[0].orders)
    orders = [fit.orders[-1] if what == "stiffness" else fit.order for fit in fits]
    misfits = [fit.misfits[what == "stiffness"] for fit in fits]
    clear = [abs(float(fit.theta[last] / fit.spread[last])) for fit in fits]
    for i in range(1, len(fits)):
        lower = min(misfits[:i])
        if max(misfits[i], 1.0) < _SHOWN * lower:
            clear[i] = np.inf
        clear[i] = min(clear[i], sqrt(independent * max(lower - misfits[i], 0.0)))
    higher = (
        "with a higher one the motion would diverge" if orders[-1] < most else "no higher order was tried"
    )
    order, reason = choose_order(orders, misfits, clear, what, higher)
    return fits[orders.index(order)], reason


def _result(
    decay: FreeDecay,
    begins: float,
    observed: Observed,
    fit: RidgeFit,
    by_order: list[RidgeFit | None],
    reasons: tuple[str, str],
) -> WaveletResult:
    per_mass, damping = _estimates(decay, fit, by_order)
    stiffness = with_mass(decay, per_mass)
    reconstruction = exact_decay(observed, fit.theta, fit.orders)
    level = np.mean(observed.samples[observed.valid] - reconstruction[observed.valid])
    time = begins + np.arange(len(observed.samples)) / decay.rate
    ridge = _curves(observed, fit, reconstruction)
    modulus, ladder, columns = _scalogram(observed)
    return WaveletResult(
        stiffness_by_order=stiffness,
        damping=damping,
        order=fit.order,
        reason=reasons[0],
        mse_percent_by_order=tuple(np.nan if one is None else one.mse_percent for one in by_order),
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
    decay: FreeDecay, fit: RidgeFit, by_order: list[RidgeFit | None]
) -> tuple[dict[int, Estimate], tuple[Estimate, ...]]:
    """Stiffness per unit mass by order, and damping, with their standard errors.

    Where viscous damping was tried, dry friction alone has the error that it has beside it, and what that would change.
    """
    stiffness, damping = fit.values
    stiffness_std, damping_std = fit.errors
    if fit.order == 0 and len(by_order) > 1:
        usual = by_order[1]
        damping_std = np.array([np.inf])
        if usual is not None:
            damping_std = np.hypot(usual.errors[1][:1], usual.values[1][:1] - damping)
    sizes = {i: (stiffness[i], std) for i, std in zip(fit.orders, stiffness_std, strict=True)}
    return stiffnesses(decay, sizes), dampings(decay, zip(damping, damping_std, strict=True))


def _curves(observed: Observed, fit: RidgeFit, reconstruction: Array) -> dict[str, Array]:
    """Envelope and frequency (Hz) freed of bias, and their models, at every sample: model plus what it leaves."""
    every, points = np.arange(len(observed.samples)), observed.points
    model = np.interp(every, points, fit.averaged)
    averaged = np.zeros(len(every))
    for order, slope in zip(fit.orders, fit.slopes, strict=True):
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
