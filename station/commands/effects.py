"""`station effects`: the library of physical effects and sensors' faults, and one of them in full."""

from pathlib import Path

import click

from station.commands.options import FILE, known_effect
from station.exits import UsageProblem
from station.output import json_option, print_json, progress, say, screen
from station.text.next_step import next_line


@click.command("effects")
@click.argument("name", required=False, callback=known_effect)
@click.option("--picture", type=FILE, metavar="FILE", help="Write its picture as PNG.")
@json_option
def command(name: str | None, picture: Path | None, as_json: bool) -> None:
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
