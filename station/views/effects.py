"""An effect in pictures: its force along one cycle, and its signature."""

from pathlib import Path

from identify.effects.effect import Effect
from station.story.effect_portrait import FREQUENCY, Portrait


def draw(effect: Effect, portrait: Portrait, file: Path) -> None:
    """Write the picture of a portrait: force over u, force over v, damping and frequency against amplitude."""
    from station.views import palette
    from station.views.figure import figure as chart
    from station.views.plots import literal

    figure, axes = chart(10.5, 6.4, 2, 2)
    length, factor = portrait.length
    unit = portrait.unit
    u, v, force = portrait.displacement * factor, portrait.velocity, portrait.force
    axes[0].plot(u, force)
    axes[0].set(
        xlabel=literal(f"displacement [{length}]"),
        ylabel=literal(f"force per unit mass [{unit}/s²]"),
        title="force over displacement",
    )
    axes[1].plot(v, force)
    axes[1].set(
        xlabel=literal(f"velocity [{unit}/s]"),
        ylabel=literal(f"force per unit mass [{unit}/s²]"),
        title="force over velocity",
    )
    found = portrait.signature
    axes[2].plot(found.amplitude * factor, found.damping)
    axes[2].set(
        xlabel=literal(f"amplitude [{length}]"),
        ylabel="equivalent damping [1/s]",
        title="damping against amplitude",
    )
    axes[3].plot(found.amplitude * factor, 50.0 * found.stiffening / FREQUENCY**2)
    axes[3].set(
        xlabel=literal(f"amplitude [{length}]"),
        ylabel="change of frequency [%]",
        title="frequency against amplitude",
    )
    figure.suptitle(f"{effect.name}: {effect.equation}", fontsize=11, color=palette.INK)
    figure.savefig(file)
