"""An identification as a plain document: what `--json` prints and `results/identification.json` keeps."""

from typing import Any

import numpy as np

from identify.estimate import Estimate
from station.story.identification import Identification


def estimate(value: Estimate) -> dict[str, Any]:
    """Return {value, std, unit}."""
    return {"value": float(value.value), "std": float(value.std), "unit": value.unit}


def as_document(name: str, result: Identification) -> dict[str, Any]:
    """Return an identification under the keys that other programs rely on.

    `wavelet`, `restoring_force` and `alignment` are None where they could not be had; `refusals` says why.
    """
    return {
        "session": name,
        "record": _record(result),
        "release": _release(result),
        "alignment": _alignment(result),
        "wavelet": _wavelet(result),
        "restoring_force": _restoring_force(result.restoring_force),
        "restoring_force_without_alignment": _restoring_force(result.without_alignment),
        "refusals": dict(result.refusals),
    }


def _record(result: Identification) -> dict[str, Any]:
    decay = result.decay
    valid = decay.valid
    return {
        "rate_hz": decay.rate,
        "samples": len(decay),
        "lost_samples": 0 if valid is None else int((~valid).sum()),
        "channels": [
            n for n in ("displacement", "velocity", "acceleration") if getattr(decay, n) is not None
        ],
        "unit": decay.unit,
        "mass_kg": decay.mass,
        "mass_std_kg": decay.mass_std,
        "noise": {
            "displacement": decay.noise_displacement,
            "velocity": decay.noise_velocity,
            "acceleration": decay.noise_acceleration,
        },
    }


def _release(result: Identification) -> dict[str, Any]:
    release, rate = result.release, result.decay.rate
    return {
        "time_s": float(release.time_s),
        "std_s": float(release.std_s),
        "kind": release.kind,
        "amplitude": amplitude(result),
        "index": int(release.index),
        "settled_s": release.settle / rate,
        "end_s": release.end / rate,
        "rest_s": [release.rest[0] / rate, release.rest[1] / rate],
    }


def amplitude(result: Identification) -> float | None:
    """Return how far the mass was from its rest at the release, m or rad, or None.

    Signed where it was held away and the displacement was measured: its mean before the release less its
    mean over the last tenth of the record. Otherwise the envelope at the start of the ridge.
    """
    displacement, rest = result.decay.displacement, result.release.rest
    if result.release.kind == "displaced" and displacement is not None and rest[1] > rest[0]:
        valid = result.decay.valid
        kept = np.ones(len(displacement), dtype=bool) if valid is None else valid
        held = displacement[rest[0] : rest[1]][kept[rest[0] : rest[1]]]
        tail = slice(len(displacement) - len(displacement) // 10, None)
        if len(held) and kept[tail].any():
            return float(np.mean(held) - np.mean(displacement[tail][kept[tail]]))
    if result.wavelet is not None and len(result.wavelet.envelope):
        return float(result.wavelet.envelope[0])
    return None


def _alignment(result: Identification) -> dict[str, Any] | None:
    found = result.alignment
    if found is None:
        return None
    return {
        "lag_s": estimate(found.lag),
        "gain": estimate(found.gain),
        "method": found.method,
        "caution": found.caution,
    }


def _wavelet(result: Identification) -> dict[str, Any] | None:
    found = result.wavelet
    if found is None:
        return None
    return {
        "stiffness": estimate(found.stiffness),
        "damping": [estimate(value) for value in found.damping],
        "order": int(found.order),
        "reason": found.reason,
        "mse_percent_by_order": [float(value) for value in found.mse_percent_by_order],
        "stiffness_by_order": {str(k): estimate(v) for k, v in found.stiffness_by_order.items()},
        "stiffness_reason": found.stiffness_reason,
        "stiffness_per_mass": estimate(found.stiffness_per_mass),
        "channel": found.channel,
    }


def _restoring_force(found: Any) -> dict[str, Any] | None:
    if found is None:
        return None
    return {
        "stiffness": estimate(found.stiffness),
        "damping": [estimate(value) for value in found.damping],
        "order": int(found.order),
        "reason": found.reason,
        "mse_percent": float(found.mse_percent),
        "mse_percent_by_order": [float(value) for value in found.mse_percent_by_order],
        "significance_percent": {str(k): float(v) for k, v in found.significance_percent.items()},
        "stiffness_by_order": {str(k): estimate(v) for k, v in found.stiffness_by_order.items()},
        "offset": estimate(found.offset),
        "stiffness_per_mass": estimate(found.stiffness_per_mass),
        "mass": None if found.mass is None else estimate(found.mass),
        "source": found.source,
    }
