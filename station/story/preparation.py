"""From a recording to a release that can be fitted: channels, release, alignment, motion."""

import math
from dataclasses import dataclass, replace

from daq.recording import Channel, Recording
from daq.session import Session
from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.fitting.baseline import fit_baseline
from identify.fitting.segments import segments_of
from identify.free_decay import CHANNELS, FreeDecay
from identify.model.model import base_model
from identify.preprocessing.aligned_decay import AlignedDecay, locate_and_align
from identify.preprocessing.prepared_decay import BESIDE_OTHERS, PreparedDecay, prepare
from station.settings import Identify, Settings
from station.story.engineering_values import Weighing

DELAY_UNCERTAINTY = 0.15
"""Relative uncertainty of a stated delay: the resistors inside of sensors are good to 15 %."""


@dataclass(frozen=True)
class Options:
    """What the operator may choose: the mass (kg, or kg m^2 for angles) and how many terms to try."""

    mass: float | None = None
    mass_std: float | None = None
    max_order: int = Identify().max_order
    stiffness_orders: tuple[int, ...] = Identify().stiffness_orders

    @property
    def orders_chosen(self) -> bool:
        """Whether the orders are other than those that are tried where nobody chose any."""
        return Identify(max_order=self.max_order, stiffness_orders=self.stiffness_orders) != Identify()


def options_for(session: Session, settings: Settings, mass: float | None = None) -> Options:
    """Return the mass as given here, by the session or by the settings, and the orders from the settings."""
    info, specimen, orders = session.info, settings.specimen, settings.identify
    stated = info if info.mass_kg is not None else specimen
    known = (stated.mass_kg, stated.mass_std_kg) if mass is None else (mass, None)
    return Options(*known, orders.max_order, orders.stiffness_orders)


def weighing_of(session: Session, settings: Settings, unit: str) -> Weighing:
    """Make what turns strengths into N, kg and s for a displacement in `unit`."""
    options = options_for(session, settings)
    return Weighing(options.mass, options.mass_std, unit)


def prepare_session(session: Session, settings: Settings, *, beside_others: bool = False) -> PreparedDecay:
    """Return the release of a session with its floor, ready to be fitted; a short one will do `beside_others`.

    Raises NotIdentifiable, with the session's name, when it holds too little.
    """
    try:
        options = options_for(session, settings)
        return with_floor(prepare_recording(session.recording(), options, beside_others=beside_others))
    except NotIdentifiable as refusal:
        raise NotIdentifiable(f"{session.folder.name}: {refusal}") from refusal


def prepare_recording(
    recording: Recording,
    options: Options,
    found: AlignedDecay | None = None,
    *,
    beside_others: bool = False,
) -> PreparedDecay:
    """Return the release of a recording, ready to be fitted; arguments and errors as `prepare_session`.

    `found` is what `locate` returns, where that is known.
    """
    gain, located = gain_uncertainty(recording), found or locate(recording, options)
    if beside_others:
        return prepare(located, gain_uncertainty=gain, fewest_cycles=BESIDE_OTHERS)
    return prepare(located, gain_uncertainty=gain)


def with_floor(prepared: PreparedDecay) -> PreparedDecay:
    """Decide the width of a release's noise floor by the usual model, so that every model is judged by the same."""
    try:
        return replace(prepared, floor_std=fit_baseline(segments_of(prepared), base_model()).spread)
    except NotIdentifiable:
        return prepared


def locate(recording: Recording, options: Options) -> AlignedDecay:
    """Return the release of a recording, located and on one clock; NotIdentifiable when there is none."""
    return locate_and_align(free_decay(recording, options))


def free_decay(recording: Recording, options: Options) -> FreeDecay:
    """Pick the channels that identification uses out of a recording.

    The first channel of each quantity is taken; a force is divided by the mass where that is
    known. Raises NotIdentifiable when no channel is a motion.
    """
    channels = {name: recording.channel(name) for name in CHANNELS}
    if all(values is None for values in channels.values()):
        present = ", ".join(channel.name for channel in recording.channels) or "none"
        raise NotIdentifiable(
            f"no channel is a displacement, a velocity or an acceleration (channels: {present}); "
            "say what they are when importing"
        )
    force = recording.channel("force")
    return FreeDecay(
        rate=recording.rate,
        displacement=channels["displacement"],
        velocity=channels["velocity"],
        acceleration=channels["acceleration"],
        valid=recording.valid,
        force=force if force is None or options.mass is None else force / options.mass,
        mass=options.mass,
        mass_std=options.mass_std,
        unit=length_unit(recording),
        rate_std=recording.rate_std,
        stated_lag=_stated_lag(recording),
    )


def motion_channels(recording: Recording) -> dict[str, Channel]:
    """Find the first channel of each quantity that is a motion, by the quantity."""
    last_first = reversed(recording.channels)
    return {channel.quantity: channel for channel in last_first if channel.quantity in CHANNELS}


def length_unit(recording: Recording) -> str:
    """Return the unit of the displacement, as the first channel that is a motion has it: m, rad, V."""
    units = [channel.unit for channel in recording.channels if channel.quantity in CHANNELS]
    return units[0].split("/")[0] if units else "m"


def _stated_lag(recording: Recording) -> Estimate | None:
    """Measure how much later the displacement (else velocity) is than the acceleration by their stated delays.

    None where no delay is stated, or one of the channels is missing.
    """
    first = motion_channels(recording)
    low, high = first.get("displacement") or first.get("velocity"), first.get("acceleration")
    if low is None or high is None or not (low.group_delay_s or high.group_delay_s):
        return None
    std = DELAY_UNCERTAINTY * math.hypot(low.group_delay_s, high.group_delay_s)
    return Estimate(low.group_delay_s - high.group_delay_s, std, "s")


def gain_uncertainty(recording: Recording) -> float:
    """Return the relative uncertainty of the gain between the channels, as their certificates leave it."""
    return math.hypot(*(share or 0.0 for share in _certified(recording)))


def calibration_of(recording: Recording, gain: float | None) -> float | None:
    """Return the relative uncertainty of the scale of the channels that are a motion; None where one has none stated.

    `gain` is that between two channels: they differ by what at least one of them is off.
    """
    stated = _certified(recording)
    if not stated or None in stated:
        return None
    off = 0.0 if gain is None else abs(gain - 1.0)
    return max(off, *(share for share in stated if share is not None))


def _certified(recording: Recording) -> list[float | None]:
    return [channel.calibration_uncertainty for channel in motion_channels(recording).values()]
