"""An effect in pictures: its force along one cycle, and its signature."""

from pathlib import Path

from identify.effects.effect import Effect
from station.story.effect_portrait import FREQUENCY, Portrait


def draw(effect: Effect, portrait: Portrait, file: Path) -> None:
    """Write the picture of a portrait: force over u, force over v, damping and frequency against amplitude."""
    from station.views.figure import figure, inked, literal
    from station.views.palette import PAPER

    (length, factor), unit, found = portrait.length, portrait.unit, portrait.signature
    displacement, amplitude = f"displacement [{length}]", (f"amplitude [{length}]", found.amplitude * factor)
    force = (f"force per unit mass [{unit}/s²]", portrait.force)
    shown = (
        ("force over displacement", (displacement, portrait.displacement * factor), force),
        ("force over velocity", (f"velocity [{unit}/s]", portrait.velocity), force),
        ("damping against amplitude", amplitude, ("equivalent damping [1/s]", found.damping)),
        (
            "frequency against amplitude",
            amplitude,
            ("change of frequency [%]", 50.0 * found.stiffening / FREQUENCY**2),
        ),
    )
    with inked(PAPER):
        drawn, axes = figure(PAPER, 6.4, 2, 2, width=10.5)
        for axis, (title, (over, x), (what, y)) in zip(axes, shown, strict=True):
            axis.plot(x, y)
            axis.set(xlabel=literal(over), ylabel=literal(what), title=title)
        drawn.suptitle(f"{effect.name}: {effect.equation}", fontsize=11)
        drawn.savefig(file)
