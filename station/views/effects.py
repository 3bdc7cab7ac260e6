"""An effect in pictures: its force along cycles of several sizes, and its signature."""

from pathlib import Path

from identify.effects.effect import Effect
from station.story.effect_portrait import FREQUENCY, Portrait


def draw(effect: Effect, portrait: Portrait, file: Path) -> None:
    """Write the picture of a portrait: force over u, force over v, damping and frequency against amplitude."""
    from station.views import palette
    from station.views.figure import figure as chart

    figure, axes = chart(10.5, 6.4, 2, 2)
    u, v, force = portrait.displacement * 1e3, portrait.velocity, portrait.force
    axes[0].plot(u, force)
    axes[0].set(
        xlabel="displacement [mm]", ylabel="force per unit mass [m/s²]", title="force over displacement"
    )
    axes[1].plot(v, force)
    axes[1].set(xlabel="velocity [m/s]", ylabel="force per unit mass [m/s²]", title="force over velocity")
    found = portrait.signature
    axes[2].plot(found.amplitude * 1e3, found.damping)
    axes[2].set(xlabel="amplitude [mm]", ylabel="equivalent damping [1/s]", title="damping against amplitude")
    axes[3].plot(found.amplitude * 1e3, 50.0 * found.stiffening / FREQUENCY**2)
    axes[3].set(
        xlabel="amplitude [mm]", ylabel="change of frequency [%]", title="frequency against amplitude"
    )
    figure.suptitle(f"{effect.name}: {effect.equation}", fontsize=11, color=palette.INK)
    figure.savefig(file)
