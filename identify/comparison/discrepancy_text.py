"""Words for a place where the model fails, in the operator's units: N with a mass, m/s^2 without."""

from dataclasses import dataclass

from identify.estimate import Estimate
from identify.formatting import quantity, scaled


@dataclass(frozen=True)
class DiscrepancyText:
    """Puts places into words for a displacement in `unit` ("m", "rad" ...) and a mass in kg, None when unknown."""

    unit: str = "m"
    mass: float | None = None

    @property
    def force_scale(self) -> float:
        """Factor from a force per unit mass to the force that is shown."""
        return 1.0 if self.mass is None else self.mass

    @property
    def force_unit(self) -> str:
        """Unit of the force that is shown."""
        if self.mass is None:
            return f"{self.unit}/s^2"
        return "N m" if self.unit == "rad" else "N"

    @property
    def energy_unit(self) -> str:
        """Unit of the energy that is shown."""
        if self.mass is not None:
            return "J"
        return "J/kg" if self.unit == "m" else f"{self.unit}^2/s^2"

    def length(self, value: float) -> str:
        """Return a length without unit, to three figures, in mm for metres."""
        return f"{value * 1e3:.3g}" if self.unit == "m" else f"{value:.3g}"

    @property
    def length_unit(self) -> str:
        """Unit of the lengths that are shown."""
        return "mm" if self.unit == "m" else self.unit

    def over_force(
        self, kind: str, force: float, at: tuple[float, float], side: int, way: int
    ) -> tuple[str, float, str]:
        """Return the sentence, the factor on a force per unit mass and the unit."""
        if kind == "force over displacement":
            place = f"{self.length(at[0])} and {self.length(at[1])} {self.length_unit}"
            verb, sense = "is", "stiffer" if force > 0 else "softer"
        else:
            place = f"{at[0]:.3g} and {at[1]:.3g} {self.unit}/s"
            verb, sense = "brakes", "more" if force > 0 else "less"
        amount = scaled(abs(force) * self.force_scale, self.force_unit)
        text = (
            f"between {place} the measured force {verb} on average {amount} {sense} than the model"
            f"{_where(side, way)}"
        )
        return text, self.force_scale, self.force_unit

    def over_cycles(
        self, kind: str, error: float, times: tuple[float, float], amplitudes: tuple[float, float]
    ) -> tuple[str, float, str]:
        """Return the sentence, the factor on the error and the unit."""
        when = f"from {times[0]:.2f} to {times[1]:.2f} s" if times[1] > times[0] else f"at {times[0]:.2f} s"
        low, high = self.length(amplitudes[0]), self.length(amplitudes[1])
        sweep = (
            f"amplitude {low} to {high} {self.length_unit}"
            if low != high
            else f"amplitude {low} {self.length_unit}"
        )
        if kind == "frequency":
            sense, cause = ("faster", "stiffer") if error > 0 else ("slower", "softer")
            text = (
                f"{when} ({sweep}) the measured motion is {abs(error):.2g} % {sense} than the model: {cause}"
            )
            return text, 1.0, "%"
        sense, cause = ("more", "more damping") if error > 0 else ("less", "less damping")
        amount = scaled(abs(error) * self.force_scale, self.energy_unit)
        text = f"{when} ({sweep}) the measured motion loses {amount} a cycle {sense} than the model: {cause}"
        return text, self.force_scale, self.energy_unit

    def at_frequency(
        self, frequency: Estimate, amplitude: float, channel: str, channels: tuple[str, ...]
    ) -> tuple[str, str]:
        """Return the sentence and the unit of the amplitude."""
        unit = {"displacement": self.unit, "velocity": f"{self.unit}/s"}.get(channel, f"{self.unit}/s^2")
        alone = f"the {channel} alone" if len(channels) == 1 else " and ".join(channels)
        size = scaled(amplitude, unit)
        text = f"at {quantity(frequency)} the {channel} has an oscillation of {size} that the model lacks"
        return (f"{text}, seen in {alone}" if channels else text), unit


def _where(side: int, way: int) -> str:
    if side == 0 and way == 0:
        return ", in both directions"
    words = "" if side == 0 else f" at {'positive' if side > 0 else 'negative'} displacement"
    return words if way == 0 else f"{words}, moving {'up' if way > 0 else 'down'}"
