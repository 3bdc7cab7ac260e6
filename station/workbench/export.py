"""Export: what was fitted of a release, the present model and what it leaves, as a table for any of the file formats."""

import numpy as np

from daq.exporting import Exported
from daq.recording import Array, Channel, Recording
from daq.session import Session
from identify.fitting.fit import Fit
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.exporting import facts_of


def fitted_samples(session: Session, prepared: PreparedDecay, fit: Fit) -> Exported:
    """Return the samples of the fit, SI: the motion, and of each channel the reading, the model and the residual.

    The motion is on one clock (the lag corrected). Readings that did not count are not a number.
    """
    window, motion = fit.windows[0], prepared.motion
    units = {
        "displacement": window.unit,
        "velocity": f"{window.unit}/s",
        "acceleration": f"{window.unit}/s^2",
    }
    columns: list[tuple[str, str, Array]] = [("time since release", "s", np.asarray(window.clock))]
    columns += [(f"{name} aligned", unit, np.asarray(getattr(motion, name))) for name, unit in units.items()]
    for channel in window.channels:
        read = np.where(window.used[channel], window.readings[channel], np.nan)
        model = fit.predicted[0][channel]
        for what, values in (("read", read), ("model", model), ("residual", read - model)):
            columns.append((f"{channel} {what}", units[channel], values))
    recording = Recording(
        window.rate,
        tuple(Channel(name, "other", unit) for name, unit, _ in columns),
        np.array([values for *_, values in columns]),
        np.ones(len(window), dtype=bool),
        rate_std=window.rate_std,
    )
    facts = {"model": " + ".join(term.effect.name for term in fit.model.terms)}
    facts |= {f"fitted {name}": f"{found.value:.9g} ± {found.std:.3g}" for name, found in fit.values.items()}
    return Exported(recording, facts_of(session) | facts)
