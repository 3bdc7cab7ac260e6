"""A comparison in words: the residual, whether a sensor or physics is to blame, and where the model fails."""

import numpy as np

from identify.formatting import plain_name, scaled, three_figures
from station.story.pipeline import Compared
from station.story.residual import floor_words, times
from station.text.content import Table, Told, facts
from station.text.layout import sentence
from station.text.numbers import scale, typeset

FEW_PLACES = 2


def told(compared: Compared) -> Told:
    """Tell a comparison."""
    found, fit, error = compared.comparison, compared.baseline.fit, compared.error
    cycles = error.horizon_s * fit.frequency / (2.0 * np.pi)
    noise = (
        f"{three_figures(compared.motion_floor)} % of the motion, {floor_words(error.floor_std)} times the noise, in a "
        f"free run of {three_figures(error.horizon_s)} s or {cycles:.0f} cycles"
    )
    places = [(f"{place.significance:.0f} sigma", typeset(place.text)) for place in found.places]
    rows = [
        ("model", " + ".join(plain_name(name) for name in fit.model.names)),
        ("fit", "" if fit.converged and not fit.unidentifiable else fit.outcome),
        ("noise alone", noise),
        ("cause", typeset(found.cause)),
        *(places[:FEW_PLACES] or [("", typeset(found.summary))]),
    ]
    more = [
        ("", compared.remark),
        ("long record", compared.one_run),
        *places[FEW_PLACES:],
        ("noise", floor_text(compared)),
    ]
    return Told(
        sentence(f"{compared.words} leaves {compared.left}"),
        "good" if compared.judged.at_floor else "bad",
        facts(rows),
        (*facts(more), errors(compared)),
    )


def errors(compared: Compared) -> Table:
    """Make the table of the three errors, with the value of noise alone and the meaning of each."""
    seen, error = compared.comparison, compared.error
    channel = f"the {seen.motion_channel}, a free run"
    rows = (
        ("motion", f"{three_figures(error.motion_percent)} %", f"{three_figures(compared.motion_floor)} %",
         f"residual of {channel}, in % of its rms"),
        ("residual", times(error.chi_square), floor_words(error.floor_std),
         f"all channels, times the noise; its square is chi-square, {three_figures(error.chi_square)}"),
        ("force", f"{three_figures(error.force_mse_percent)} %", f"{three_figures(seen.force_floor)} %",
         "of the force's mean square, taken at the measured motion"),
    )  # fmt: skip
    return Table("", ("error", "model", "noise", "what it is"), rows, wordy=True)


def floor_text(compared: Compared) -> str:
    """Write the noise of each channel with its uncertainty and where it came from."""
    found = compared.comparison
    parts = []
    for name, noise in found.floor.items():
        share = 100.0 * noise.uncertainty / noise.std if noise.std > 0 else float("nan")
        unit = scale(name, found.unit)[1] if name != "displacement" else found.unit
        parts.append(f"{name} {scaled(noise.std, unit)} ± {share:.0f} % ({noise.source})")
    return typeset(f"used by the fit: {'; '.join(parts)}")
