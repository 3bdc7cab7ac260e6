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
    from identify.comparison.compare import Comparison as Comparison, compare as compare
    from identify.curves.laid_over import DecayCurves as DecayCurves, decay_curves as decay_curves
    from identify.diagnosis.diagnose import Diagnosis as Diagnosis, diagnose as diagnose
    from identify.diagnosis.ladder import (
        Ladder as Ladder,
        Step as Step,
        add_effect as add_effect,
        first_step as first_step,
        remove_effect as remove_effect,
    )
    from identify.effects.effect import Effect as Effect, Parameter as Parameter
    from identify.effects.library import LIBRARY as LIBRARY, find_effect as find_effect
    from identify.effects.user.definition import own_effect as own_effect, parse_effect as parse_effect
    from identify.errors import NotIdentifiable as NotIdentifiable
    from identify.estimate import Estimate as Estimate
    from identify.fitting.prediction import Prediction as Prediction, predict as predict
    from identify.fitting.validation import Validation as Validation, validate as validate
    from identify.free_decay import FreeDecay as FreeDecay
    from identify.judging.suspect import Suspect as Suspect
    from identify.model.model import Model as Model, Term as Term, base_model as base_model
    from identify.preprocessing.aligned_decay import (
        AlignedDecay as AlignedDecay,
        locate_and_align as locate_and_align,
    )
    from identify.preprocessing.alignment import Alignment as Alignment
    from identify.preprocessing.prepared_decay import PreparedDecay as PreparedDecay, prepare as prepare
    from identify.restoring_force.restoring_force import (
        RestoringForceResult as RestoringForceResult,
        identify_restoring_force as identify_restoring_force,
    )
    from identify.wavelet.wavelet import WaveletResult as WaveletResult, identify_wavelet as identify_wavelet

_HOMES = {
    "comparison.compare": ("Comparison", "compare"),
    "curves.laid_over": ("DecayCurves", "decay_curves"),
    "diagnosis.diagnose": ("Diagnosis", "diagnose"),
    "diagnosis.ladder": ("Ladder", "Step", "add_effect", "first_step", "remove_effect"),
    "judging.suspect": ("Suspect",),
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

__all__ = [name for names in _HOMES.values() for name in names]


def __getattr__(name: str) -> Any:
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"identify.{home}"), name)
    raise AttributeError(f"module 'identify' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
