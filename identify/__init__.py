"""Which forces act on a released mass, how well a model explains them, and which effect it lacks.

From two arrays to a named effect:

    import identify

    decay = identify.FreeDecay(rate, displacement, acceleration)
    diagnosis = identify.diagnose(decay)
    print(diagnosis)
    print(diagnosis.refine())

Arrays in, frozen results out; nothing here opens a file, a port or a screen. Names are imported when they are first
used, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from identify.comparison.compare import Comparison, compare
    from identify.curves.laid_over import DecayCurves, decay_curves
    from identify.diagnosis.diagnose import Diagnosis, diagnose, refine
    from identify.diagnosis.ladder import Ladder, Step, add_effect, first_step, remove_effect
    from identify.diagnosis.suspect import Suspect
    from identify.effects.effect import Effect, Parameter
    from identify.effects.library import LIBRARY, find_effect
    from identify.effects.user.definition import own_effect, parse_effect
    from identify.errors import NotIdentifiable
    from identify.estimate import Estimate
    from identify.fitting.prediction import Prediction, predict
    from identify.fitting.validation import Validation, validate
    from identify.free_decay import FreeDecay
    from identify.model.model import Model, Term, base_model
    from identify.preprocessing.aligned_decay import AlignedDecay, locate_and_align
    from identify.preprocessing.alignment import Alignment
    from identify.preprocessing.prepared_decay import PreparedDecay, prepare
    from identify.restoring_force.restoring_force import RestoringForceResult, identify_restoring_force
    from identify.wavelet.wavelet import WaveletResult, identify_wavelet

__all__ = [
    "LIBRARY",
    "AlignedDecay",
    "Alignment",
    "Comparison",
    "DecayCurves",
    "Diagnosis",
    "Effect",
    "Estimate",
    "FreeDecay",
    "Ladder",
    "Model",
    "NotIdentifiable",
    "Parameter",
    "Prediction",
    "PreparedDecay",
    "RestoringForceResult",
    "Step",
    "Suspect",
    "Term",
    "Validation",
    "WaveletResult",
    "add_effect",
    "base_model",
    "compare",
    "decay_curves",
    "diagnose",
    "find_effect",
    "first_step",
    "identify_restoring_force",
    "identify_wavelet",
    "locate_and_align",
    "own_effect",
    "parse_effect",
    "predict",
    "prepare",
    "refine",
    "remove_effect",
    "validate",
]

_HOMES = {
    "comparison.compare": ("Comparison", "compare"),
    "curves.laid_over": ("DecayCurves", "decay_curves"),
    "diagnosis.diagnose": ("Diagnosis", "diagnose", "refine"),
    "diagnosis.ladder": ("Ladder", "Step", "add_effect", "first_step", "remove_effect"),
    "diagnosis.suspect": ("Suspect",),
    "effects.effect": ("Effect", "Parameter"),
    "effects.library": ("LIBRARY", "find_effect"),
    "effects.user.definition": ("own_effect", "parse_effect"),
    "errors": ("NotIdentifiable",),
    "estimate": ("Estimate",),
    "fitting.prediction": ("Prediction", "predict"),
    "fitting.validation": ("Validation", "validate"),
    "free_decay": ("FreeDecay",),
    "model.model": ("Model", "Term", "base_model"),
    "preprocessing.aligned_decay": ("AlignedDecay", "locate_and_align"),
    "preprocessing.alignment": ("Alignment",),
    "preprocessing.prepared_decay": ("PreparedDecay", "prepare"),
    "restoring_force.restoring_force": ("RestoringForceResult", "identify_restoring_force"),
    "wavelet.wavelet": ("WaveletResult", "identify_wavelet"),
}


def __getattr__(name: str) -> Any:
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"identify.{home}"), name)
    raise AttributeError(f"module 'identify' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
