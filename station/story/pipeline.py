"""The story: recording -> release -> noise -> alignment -> wavelet, restoring force.

Each step takes the last one's value and returns its own. A step that cannot be done says why, and the
others still run.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from daq.recording import Recording
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import locate_and_align
from identify.restoring_force.restoring_force import (
    identify_restoring_force,
    identify_restoring_force_as_recorded,
)
from identify.wavelet.wavelet import identify_wavelet
from station.story.identification import Identification

Value = TypeVar("Value")

MOTION = ("displacement", "velocity", "acceleration")


@dataclass(frozen=True)
class Options:
    """What the operator may choose: the mass (kg, or kg m^2 for angles) and how many terms to try."""

    mass: float | None = None
    mass_std: float | None = None
    max_order: int = 3
    stiffness_orders: tuple[int, ...] = (1,)


def identify(recording: Recording, options: Options) -> Identification:
    """Tell the story of one recording with one release.

    Raises NotIdentifiable when no release can be found, since nothing can follow then.
    """
    refusals: dict[str, str] = {}

    def attempt(step: str, act: Callable[[], Value]) -> Value | None:
        try:
            return act()
        except NotIdentifiable as refusal:
            refusals[step] = str(refusal)
            return None

    found = locate_and_align(free_decay(recording, options))
    decay, alignment, aligned = found.recorded, found.alignment, found.decay
    if found.not_aligned:
        refusals["alignment"] = found.not_aligned

    wavelet = None
    if decay.driven:
        refusals["wavelet"] = (
            "a force drives the motion to the end of the record; this method needs a free decay"
        )
    else:
        wavelet = attempt("wavelet", lambda: identify_wavelet(aligned, options.max_order))

    orders = (options.max_order, options.stiffness_orders)
    restoring_force = attempt("restoring_force", lambda: identify_restoring_force(aligned, *orders))
    without_alignment = None
    if alignment is not None and decay.displacement is not None:
        without_alignment = attempt(
            "without_alignment", lambda: identify_restoring_force_as_recorded(decay, *orders)
        )

    return Identification(
        decay, found.release, alignment, aligned, wavelet, restoring_force, without_alignment, refusals
    )


def free_decay(recording: Recording, options: Options) -> FreeDecay:
    """Pick the channels that identification uses out of a recording.

    The first channel of each quantity is taken; a force is divided by the mass where that is
    known. Raises NotIdentifiable when no channel is a motion.
    """
    channels = {name: recording.channel(name) for name in MOTION}
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
        unit=_displacement_unit(recording),
    )


def _displacement_unit(recording: Recording) -> str:
    """Return the unit of the displacement, as the first channel that is a motion has it: m, rad, V."""
    units = [channel.unit for channel in recording.channels if channel.quantity in MOTION]
    return units[0].split("/")[0] if units else "m"
