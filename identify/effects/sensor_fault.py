"""A fault of a sensor: it changes what a channel reads, not the motion."""

from collections.abc import Callable
from dataclasses import dataclass, field

from identify.arrays import Array
from identify.effects.effect import Effect, Scales, Starts


@dataclass(frozen=True, eq=False, kw_only=True)
class SensorFault(Effect):
    """A fault of a sensor: it changes the readings of one channel, and so breaks a = D^2 u.

    `observe(time, reading, p)` takes the predicted readings of one channel before its offset, shape (n,), at `time` (s
    since the release) and returns what the faulty sensor would show. `starts(scales, channel)` lists starting values of
    all parameters, of which the `inner` ones act out of proportion. A fault that `shows_at_rest` is looked for
    there too; `seems_lag(start, scales)` is by how much it makes its channel seem early (s). A fault that
    `needs_other_channel` looks like a force where there is one channel only, and is no suspect there. One that is
    `corrected_in_every_fit` has no parameters there and is no suspect either: it is judged by what the fit allowed for.
    """

    kind = "sensor"
    variants: tuple[dict[str, float | str], ...] = tuple(
        {"channel": channel} for channel in ("displacement", "acceleration", "velocity")
    )
    observe: Callable[[Array, Array, Array], Array] = field(default=lambda time, reading, p: reading)
    starts: Callable[[Scales, str], Starts] = field(default=lambda scales, channel: ())
    inner: tuple[str, ...] = ()
    shows_at_rest: bool = False
    seems_lag: Callable[[tuple[float, ...], Scales], float] | None = None
    needs_other_channel: bool = False
    corrected_in_every_fit: bool = False

    def starting_values(self, scales: Scales, channel: str) -> Starts:
        """Return starting values of all parameters; none where the channel, or another one that it takes, is absent."""
        absent = channel not in scales.peaks or (self.needs_other_channel and len(scales.peaks) < 2)
        return () if absent else self.starts(scales, channel)
