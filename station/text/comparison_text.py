"""A comparison in words: the residual, whether a sensor or physics is to blame, and where the model fails."""

import numpy as np

from identify.fitting.model_error import may_hide_anything, noise_percent
from identify.formatting import plain_name, three_figures
from identify.residual import floor_words
from station.story.pipeline import Compared
from station.text.content import Told, facts
from station.text.layout import sentence
from station.text.numbers import noise_words, typeset

FEW_PLACES = 2


def told(compared: Compared) -> Told:
    """Tell a comparison."""
    found, fit, error = compared.comparison, compared.baseline.fit, compared.error
    cycles = error.horizon_s * fit.frequency / (2.0 * np.pi)
    alone = three_figures(noise_percent(compared.judged.fit))
    noise = (
        f"{alone} % of the motion, {floor_words(error.floor_std)} times the noise, in a free run "
        f"of {three_figures(error.horizon_s)} s or {cycles:.0f} cycles"
    )
    force = (
        f"{three_figures(error.force_mse_percent)} % of its mean square at the measured motion is left; "
        f"{three_figures(found.force_floor)} % by noise alone"
    )
    places = [(f"{place.significance:.0f} sigma", typeset(place.text)) for place in found.places]
    guessed = "The noise of this record is only a guess, and may be as large as what is left: the places below may be noise."
    rows = [
        ("model", " + ".join(plain_name(name) for name in fit.model.names)),
        ("fit", "" if fit.converged and not fit.unidentifiable else fit.outcome),
        ("noise alone", noise),
        ("caution", guessed if may_hide_anything(compared.judged, compared.judged.fit) else ""),
        ("cause", typeset(found.cause)),
        *(places[:FEW_PLACES] or [("", typeset(found.summary))]),
    ]
    more = [
        ("", compared.remark),
        ("long record", compared.one_run),
        *places[FEW_PLACES:],
        (
            "chi-square",
            f"{three_figures(error.chi_square)}, the square of the residual over the noise, in all channels",
        ),
        ("force", force),
        ("noise", floor_text(compared)),
    ]
    return Told(
        sentence(f"{compared.words} leaves {compared.left}"),
        "good" if compared.judged.at_floor else "bad",
        facts(rows),
        facts(more),
    )


def floor_text(compared: Compared) -> str:
    """Write the noise of each channel with its uncertainty and where it came from."""
    found = compared.comparison
    parts = []
    for name, noise in found.floor.items():
        share = 100.0 * noise.uncertainty / noise.std if noise.std > 0 else float("nan")
        parts.append(f"{noise_words(name, noise.std, found.unit)} ± {share:.0f} % ({noise.source})")
    return typeset(f"used by the fit: {'; '.join(parts)}")
