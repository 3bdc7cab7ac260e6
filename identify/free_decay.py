"""A free decay: one release, as it was recorded."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from identify.arrays import Array, Mask, frozen, frozen_mask
from identify.estimate import Estimate
from identify.formatting import scaled
from identify.summary import Summarised, Summary

CHANNELS = ("displacement", "velocity", "acceleration")
"""The channels of a motion, by the number of derivatives."""

_STILL_DRIVEN = 0.05


@dataclass(frozen=True, eq=False, repr=False)
class FreeDecay(Summarised):
    """One release of a mass on springs, from the rest before it to the end of the record.

    All channels that are present have the same length n and share one clock; sample i lies at
    `i / rate` seconds. Quantities are SI (m or rad, per second, per second squared). At least one of
    `displacement`, `velocity`, `acceleration` is present.

    `release` is the first sample of free motion (0 when the record begins in mid-decay), None when it has not
    been located yet: whatever identifies then locates it first. `rest` is the half-open range of samples before the
    release in which the mass is held still, empty (0, 0) when there is none. `valid` is False where a sample was
    lost; the values there mean nothing. `noise_*` are white-noise standard deviations of the channels, None when
    unknown.
    `force` is an external force per unit mass (m/s^2) when one was recorded. `mass` is in kg
    (kg m^2 for angles), None when unknown: everything is then per unit mass. `rate_std` is the standard error of the
    rate in Hz, None when unknown: it enters every error of a value that holds a time. `stated_lag` is by how much
    the displacement (or velocity) is later than the acceleration by the sensors' data sheets, with its standard error (s).
    """

    rate: float
    displacement: Array | None = None
    acceleration: Array | None = None
    velocity: Array | None = None
    release: int | None = None
    rest: tuple[int, int] = (0, 0)
    valid: Mask | None = None
    noise_displacement: float | None = None
    noise_velocity: float | None = None
    noise_acceleration: float | None = None
    force: Array | None = None
    mass: float | None = None
    mass_std: float | None = None
    unit: str = "m"
    rate_std: float | None = None
    stated_lag: Estimate | None = None

    def __post_init__(self) -> None:
        lengths = set()
        for name in ("displacement", "velocity", "acceleration", "force"):
            values = getattr(self, name)
            if values is not None:
                object.__setattr__(self, name, frozen(values))
                lengths.add(len(values))
        if self.valid is not None:
            object.__setattr__(self, "valid", frozen_mask(self.valid))
            lengths.add(len(self.valid))
        if not self.channels:
            raise ValueError("a free decay needs a displacement, a velocity or an acceleration")
        if len(lengths) != 1:
            raise ValueError(f"channels of different lengths: {sorted(lengths)}")
        if not (np.isfinite(self.rate) and self.rate > 0):
            raise ValueError(f"the rate must be positive, not {self.rate} Hz")

    def __len__(self) -> int:
        return len(next(iter(self.channels.values())))

    @property
    def channels(self) -> dict[str, Array]:
        """The readings of the channels that are present, shape (n,) each, the lowest derivative first."""
        return {name: values for name in CHANNELS if (values := getattr(self, name)) is not None}

    @property
    def known(self) -> Mask:
        """Which samples were recorded and are numbers in every channel, shape (n,)."""
        known = np.ones(len(self), dtype=np.bool_) if self.valid is None else self.valid.copy()
        for values in self.channels.values():
            known &= np.isfinite(values)
        return known

    @property
    def start(self) -> int:
        """The first sample of free motion; 0 where the release has not been located."""
        return self.release or 0

    @property
    def driven(self) -> bool:
        """Whether a recorded force acts to the end; one that dies away, as a hammer's, leaves a free decay."""
        if self.force is None:
            return False
        return bool(np.std(self.force[len(self) // 2 :]) > _STILL_DRIVEN * np.std(self.force))

    @property
    def time(self) -> Array:
        """Time of each sample, shape (n,), s, from the first sample."""
        return np.arange(len(self)) / self.rate

    def brief(self) -> Summary:
        """Return the channels with their ranges and noise, and where the motion becomes free."""
        where = "the release has not been located"
        if self.release is not None:
            where = (
                f"free from {self.start / self.rate:.3f} s on" if self.start else "in motion from the start"
            )
        lost = 0 if self.valid is None else int((~self.valid).sum())
        size = f"{len(self)} samples at {self.rate:g} Hz ({len(self) / self.rate:.4g} s)"
        sentences = (f"{size}; {where}; {lost} samples lost.",)
        units = {"displacement": self.unit, "velocity": f"{self.unit}/s", "acceleration": f"{self.unit}/s^2"}
        rows = []
        for name, values in self.channels.items():
            sizes = (np.nanmin(values), np.nanmax(values), getattr(self, f"noise_{name}"))
            rows.append(
                (name, *("unknown" if size is None else scaled(float(size), units[name]) for size in sizes))
            )
        return Summary("Free decay", sentences, ("channel", "lowest", "highest", "noise"), rows)

    def with_(self, **changes: object) -> Self:
        """Return a copy with some fields replaced."""
        return replace(self, **changes)  # type: ignore[arg-type]
