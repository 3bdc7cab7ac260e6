"""How weak an effect can be seen at all, and how near the parameters come to the Cramer-Rao bound."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np

from bench.diagnosis import EFFECTS, Case, setting_of
from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import fit
from identify.fitting.initial_values import initial_values
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

TITLE = "Bounds"
_NOISE = {"displacement": 5e-6, "acceleration": 0.01}
SEEN = 25.0
"""Drop of chi-square at which an effect is named in about half of the cases, after the search over the library."""


def expected_drop(job: tuple[str, float, int]) -> float:
    """Return the chi-square that the best base model leaves of a noise-free record, in units of the working noise."""
    effect, strength, seed = job
    try:
        sample = draw(
            effect,
            strength,
            seed,
            noise_displacement=1e-7,
            noise_acceleration=2e-4,
            bits=22,
            amplitude=0.02,
            release_time=0.0,
        )
        setting = prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration))
        span = setting.window.with_(sigma=dict(_NOISE))
        setting = replace(setting, window=span)
        return fit(
            base_model(), (span,), initial_values((setting,), base_model(), {}), setting.frequency
        ).chi_square
    except (NotIdentifiable, ValueError):
        return float("nan")


def scores(seed: int) -> list[float]:
    """Return the errors of K, mu_0, mu_1 and lag over their Cramer-Rao bounds, on a record with nothing hidden."""
    setting, truth = setting_of(Case(None, 0.0, 7000 + seed))
    values = fit_baseline((setting,), base_model()).fit.values
    known = {
        "linear_stiffness.k": truth["stiffness_per_mass"],
        "coulomb_friction.mu_0": truth["mu_0"],
        "viscous_damping.mu_1": truth["mu_1"],
        "lag": truth["displacement_late_s"],
    }
    return [(values[name].value - true) / values[name].std for name, true in known.items()]


def expected_drops(strength: float, seeds: int) -> np.ndarray:
    """Return the expected drop of chi-square, (effects, seeds)."""
    with ProcessPoolExecutor() as pool:
        jobs = [(e, strength, 600 + i) for e in EFFECTS for i in range(seeds)]
        return np.array(list(pool.map(expected_drop, jobs, chunksize=4))).reshape(len(EFFECTS), seeds)


def run(quick: bool) -> str:
    """Return the tables as markdown."""
    seeds = 2 if quick else 6
    strength = 0.002
    drops = expected_drops(strength, seeds)
    with ProcessPoolExecutor() as pool:
        z = np.array(list(pool.map(scores, range(16 if quick else 80), chunksize=4)))
    medians = np.nanmedian(drops, axis=1)
    half = 100 * strength * np.sqrt(SEEN / np.maximum(medians, 1e-9))
    least, most = (f"{EFFECTS[at]}, {half[at]:.2g} %" for at in (np.nanargmin(half), np.nanargmax(half)))
    ratio = np.sqrt(np.mean(z**2, axis=0))
    words = ", ".join(f"{n} {r:.2f}" for n, r in zip(("K", "mu_0", "mu_1", "lag"), ratio, strict=True))
    return (
        f"The strength at which the usual model leaves {SEEN:.0f} of chi-square beyond the noise (20 mm, {seeds} seeds), median "
        f"of {len(EFFECTS)} effects: {np.nanmedian(half):.2g} %; least: {least}; most: {most}."
        f"\n\nRms errors over the Cramer-Rao bound, {len(z)} records: {words} (wanted at most 1.2)."
    )
