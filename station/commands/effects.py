"""`station effects`: the library of physical effects and sensors' faults, and one of them in full."""

from station.commands.options import argument, declared, known_effect
from station.exits import UsageProblem


@declared("effects")
def command(name: str | None = argument(required=False, callback=known_effect)) -> None:
    """List the effects that may be missing, or describe NAME.

    With NAME: its equation, parameters with units and bounds, how it shows,
    what proves it, and what it is confused with.
    """
    from identify.effects.library import LIBRARY, find_effect
    from station.text import effect_text
    from station.text.layout import answer

    if name is not None:
        try:
            effect = find_effect(name)
        except KeyError as missing:
            raise UsageProblem(str(missing.args[0])) from None
        answer(effect_text.as_document(effect), effect_text.told(effect), full=True)
    else:
        document = {"effects": [effect_text.as_document(effect) for effect in LIBRARY]}
        answer(document, effect_text.all_told(LIBRARY), "effects", "NAME")
