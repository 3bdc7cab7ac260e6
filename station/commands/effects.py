"""`station effects`: the library of physical effects and sensors' faults, and one of them in full."""

from pathlib import Path

from station.commands.options import JSON, argument, declared, known_effect, option
from station.exits import UsageProblem
from station.output import print_json, progress, say, screen
from station.text.next_step import next_line


@declared("effects")
def command(
    name: str | None = argument(required=False, callback=known_effect),
    picture: Path | None = option("Write its picture as PNG.", metavar="FILE"),
    as_json: bool = JSON,
) -> None:
    """List the effects that may be missing, or describe NAME.

    With NAME: its equation, parameters with units and bounds, how it shows,
    what proves it, what it is confused with, its force and its signature.
    """
    from identify.effects.force_effect import ForceEffect
    from identify.effects.library import LIBRARY, find_effect
    from station.story.effect_portrait import portray
    from station.text import effect_text
    from station.views.effects import draw

    if name is None:
        if picture is not None:
            raise UsageProblem("--picture draws one effect: name it, as in `station effects cubic_stiffness`")
        if as_json:
            print_json({"effects": [effect_text.as_document(effect, None) for effect in LIBRARY]})
        else:
            effect_text.show_list(screen(), LIBRARY)
        return
    try:
        effect = find_effect(name)
    except KeyError as missing:
        raise UsageProblem(str(missing.args[0])) from None
    portrait = portray(effect) if isinstance(effect, ForceEffect) else None
    if picture is not None:
        if portrait is None:
            raise UsageProblem(f"{name} is a fault of a sensor: it has no force to draw")
        draw(effect, portrait, picture)
        progress(f"picture: {picture}")
    if as_json:
        print_json(effect_text.as_document(effect, portrait))
    else:
        effect_text.show_effect(screen(), effect, portrait)
        say(next_line("refine", "last", "--add", name))
