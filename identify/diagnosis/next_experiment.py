"""What to record next, in a sentence: the release that was chosen, or what to do where none can be."""

from identify.diagnosis.next_release import NextRelease
from identify.diagnosis.suspect import Suspect
from identify.fitting.baseline import Baseline

_MORE = "Record at least eight seconds or ten cycles, from the largest amplitude that is safe."
_AT_OTHER_LEVELS = "Drive it at half and at one and a half times the level"


def next_experiment(
    baseline: Baseline, verdict: str, suspects: tuple[Suspect, ...], chosen: NextRelease | None
) -> str:
    """Return what to record next, in a sentence."""
    if verdict == "not_enough_data":
        return _MORE
    if verdict == "driven":
        return "Stop the drive and release the mass."
    if verdict == "sensor_fault" and not suspects[0].rivals:
        return _confirming(suspects[0])
    if chosen is not None:
        together = " Diagnose it together with what there is." if verdict == "unknown_effect" else ""
        return chosen.words + together
    if baseline.decays[0].window.force is not None:
        hides = verdict == "nothing_missing"
        why = (
            "effects hide that grow faster"
            if hides
            else "the shape of the missing force must be the same in each"
        )
        return f"{_AT_OTHER_LEVELS}: {why}."
    if verdict == "missing_effect":
        return _confirming(suspects[0])
    return (
        "Release it from half and from twice the amplitude, and diagnose these together with what there is."
    )


def _confirming(suspect: Suspect) -> str:
    test = suspect.effect.confirming_test
    return f"{test[0].upper()}{test[1:]}."
