"""Pictures for a notebook: `draw(result)` gives a figure of whatever `identify` returned."""

import numpy as np

from daq.recording import Channel, Recording
from identify.comparison.compare import Comparison
from identify.curves.laid_over import DecayCurves
from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.ladder import Ladder
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.restoring_force.restoring_force import RestoringForceResult
from identify.wavelet.wavelet import WaveletResult
from station.results.diagnosis_pictures import MOST, force_maps
from station.story.engineering_values import Weighing
from station.views import comparison_figures, diagnosis_figures, identification_figures
from station.views.figure import Picture, figure, inked, literal
from station.views.palette import LIGHT


def draw(result: object) -> Picture:
    """Draw a result of `identify`; TypeError where there is no picture for it."""
    with inked(LIGHT):
        match result:
            case FreeDecay():
                return _record(result)
            case PreparedDecay():
                return _prepared(result)
            case WaveletResult():
                return identification_figures.envelope(result, "SI", 0.0)
            case RestoringForceResult():
                unit = result.offset.unit.partition("/")[0]
                return identification_figures.sections(result, Weighing(unit=unit))
            case Comparison():
                return comparison_figures.phase_plane(result)
            case Diagnosis():
                return _missing(result)
            case DecayCurves():
                count = 1 + max(curve.release for curve in result.releases)
                return diagnosis_figures.curves(result, [f"release {1 + n}" for n in range(count)])
            case Ladder():
                names = [row[0] for row in result.brief().rows]
                steps = list(zip(names, (step.fit for step in result.steps), strict=True))
                return comparison_figures.front([*steps[:1], *steps[1:][-1:]])
    raise TypeError(f"there is no picture of a {type(result).__name__}")


def _record(decay: FreeDecay) -> Picture:
    units = {"displacement": decay.unit, "velocity": f"{decay.unit}/s", "acceleration": f"{decay.unit}/s^2"}
    recording = Recording(
        rate=decay.rate,
        channels=tuple(Channel(name, name, units[name]) for name in decay.channels),
        samples=np.array(list(decay.channels.values())),
        valid=decay.known,
    )
    return identification_figures.record(recording, decay.start / decay.rate or None)


def _prepared(prepared: PreparedDecay) -> Picture:
    motion, unit = prepared.motion, prepared.window.unit
    picture, axes = figure(LIGHT, 3.2, 1, 2)
    axes[0].plot(prepared.time, motion.displacement, color=LIGHT.measured, linewidth=0.8)
    axes[0].set(xlabel="time since the release [s]", ylabel=literal(f"displacement [{unit}]"))
    axes[1].plot(motion.displacement, prepared.restoring, ".", color=LIGHT.measured, markersize=1.5)
    axes[1].set(
        xlabel=literal(f"displacement [{unit}]"),
        ylabel=literal(f"restoring {Weighing(unit=unit).worded()} [{unit}/s²]"),
    )
    return picture


def _missing(found: Diagnosis) -> Picture:
    place = int(np.argmax([prepared.amplitude for prepared in found.baseline.decays]))
    prepared, base = found.baseline.decays[place], found.baseline.fit
    best = [(s.term, s.fit) for s in found.suspects if s.effect.name in s.fit.model][:MOST]
    maps = force_maps(prepared, base, best, place)
    return diagnosis_figures.force_maps(maps, Weighing(unit=prepared.window.unit))
