"""The explanation where prediction decides: what predicts, what does not, and a motion that does not die away."""

import numpy as np

from identify.curves.confirmation import Confirmation
from identify.curves.decay_curve import DecayCurve
from identify.fitting.misfit_errors import is_clear
from identify.formatting import (
    among,
    odds_words,
    plain_name,
    quantities,
    sentence_case,
    share_words,
    three_figures,
)
from identify.judging.suspect import Suspect
from identify.residual import share_explained

_NEARLY_ALL = 0.9
"""Share of what the model leaves above the noise that a force must explain to be spoken of though its strength is unsure."""

_KINDS = {"frequency": "the frequency", "loss": "the loss per cycle"}


def explain_confirmed(suspects: tuple[Suspect, ...], found: Confirmation) -> str:
    """Explain which effects are missing, what they predict, and what has no name; `suspects` are those that are named."""
    sentences = []
    for suspect in suspects:
        effect = suspect.confirmed
        if effect is None:
            continue
        alike = f"; {_among(effect.rivals)} would explain it nearly as well" if effect.rivals else ""
        sentences.append(
            f"The missing effect is {plain_name(suspect.effect.name)}, which changes {_KINDS[effect.explains]} with the "
            f"amplitude: the prediction error falls from {three_figures(effect.before)} to "
            f"{three_figures(effect.after)} % of the motion. The odds against a random walk of the rig, or a law outside "
            f"the library, are {odds_words(effect.nats)}{alike}."
        )
    predicted = [_prediction(found)] * (len(sentences) == len(found.effects))
    return " ".join([*sentences, *predicted, *_undecided(found)])


def explain_unconfirmed(found: Confirmation, suspects: tuple[Suspect, ...], before: float) -> str:
    """Explain that no effect predicts the residual, how large it is, and what may cause it.

    `before` is the reduced chi-square of the model.
    """
    size = three_figures(found.usual.typical("motion"))
    part, parts = ("range", "ranges") if found.one_record else ("release", "releases")
    of = " of amplitudes" if found.one_record else ""
    others = f"the other {part if found.parts == 2 else parts}{of}"
    nearly = [_not_sure(one, before) for one in suspects[:1]]
    predicted = (
        f"Fitted to {others}, the model predicts the amplitude and the phase of each {part} with an error of {size} % of "
        "the motion."
    )
    said = [*_undecided(found), *filter(None, nearly), predicted]
    if len(said) == 1:
        said.append("No effect of the library explains it better than a random walk of the rig would.")
    return " ".join(said)


def _not_sure(leading: Suspect, before: float) -> str:
    """Say of a force that would explain nearly all of it what keeps it from a name; "" where it is no such force."""
    name, strength = leading.effect.strength.name, leading.parameters.get(leading.effect.strength.name)
    share = share_explained(before, leading.error_after)
    if leading.kind != "physics" or not leading.claimed or share < _NEARLY_ALL or strength is None:
        return ""
    would = f"{sentence_case(plain_name(leading.effect.name))} would explain {share_words(share)} of what the model leaves"
    if not is_clear(leading.fit, leading.term):
        return f"{would}, but its strength, {quantities({name: strength})[0]}, may be zero."
    if not leading.rivals:
        return ""
    return f"{would}; this record does not distinguish it from {_among(leading.rivals, 'or')}."


def explain_driven(curve: DecayCurve, unit: str) -> str:
    """Explain that the motion does not die away, with the amplitude and the frequency at which it goes on."""
    frequency = float(np.median(curve.frequency[len(curve) // 2 :])) / (2.0 * np.pi)
    late = curve.late
    if curve.grows:
        return (
            f"The motion grows to {three_figures(late.max())} {unit} at {three_figures(frequency)} Hz. Something feeds it; "
            "a free decay is needed to name a force. Stop the drive, or find what feeds the motion, before a release."
        )
    between = f"{three_figures(late.min())} and {three_figures(late.max())} {unit}"
    beats = f", beating between {between}" if curve.beats_late else ""
    return (
        f"The motion does not die away: over the last two fifths of the record its amplitude stays at "
        f"{three_figures(float(np.mean(late)))} {unit} and {three_figures(frequency)} Hz{beats}. Something drives it; a "
        "free decay is needed to name a force. Stop the drive and release the mass, or record the driving force as a "
        "channel of its own."
    )


def _prediction(found: Confirmation) -> str:
    """State on how many parts the prediction is confirmed, and its error before and after."""
    before, after = found.usual.typical("motion"), found.found.typical("motion")
    left = "" if after < 1.0 else f"; no effect is named for the remaining {three_figures(after)} %"
    basis = f"Confirmed on {found.better} of {found.parts} other releases"
    if found.one_record:
        basis = f"Confirmed within this record: {found.better} of {found.parts} ranges of amplitude predicted from the rest"
    return f"{basis}; prediction error from {three_figures(before)} to {three_figures(after)} % of the motion{left}."


def _undecided(found: Confirmation) -> list[str]:
    """Say what changes although no effect is named for it, and which effects would explain that."""
    sentences, too = [], ", too" if found.effects else ""
    for what, names in found.undecided.items():
        doubt = f"and {'this record' if found.one_record else 'these records'} cannot tell which"
        doubt = doubt if len(names) > 1 else "but not surely enough for a name"
        sentences.append(
            f"{_KINDS[what].capitalize()} changes{too}: {_among(names, 'or')} would explain it, {doubt}."
        )
    return sentences


def _among(names: tuple[str, ...], word: str = "and") -> str:
    return among([plain_name(name) for name in names], word)
