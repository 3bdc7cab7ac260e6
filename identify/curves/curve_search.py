"""The ground of a search on curves: regression, predictions, and what windows and averaging do to each model."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identify.arrays import Array
from identify.curves.averaged_law import AveragedLaw, amplitude_grid, inner_of, law_of, laws_of, values_of
from identify.curves.curve_regression import CurveRegression, HeldOut, Rows, cut_by_amplitude, hold_out
from identify.curves.decay_curve import DecayCurve
from identify.curves.isolated_mode import IsolatedMode, simulated_curve
from identify.effects.effect import Scales
from identify.fitting.own_linear import shares_of
from identify.model.model import Model, Term
from identify.preprocessing.prepared_decay import PreparedDecay

_ROUNDS = 4
_SETTLED = 0.005
"""Rounds of correction at most, and the share of the typical loss by which the last may still move the rows."""


class CurveSearch:
    """The search on some releases: regression, corrections by simulation, and the laws taken so far."""

    def __init__(
        self,
        decays: tuple[PreparedDecay, ...],
        modes: tuple[IsolatedMode, ...],
        model: Model,
        known: dict[str, float],
        terms: tuple[Term, ...],
        scales: Scales,
    ) -> None:
        self.decays, self.modes, self.model, self.known = decays, modes, model, known
        self.scales = scales
        self.whole = tuple(
            mode.curve(np.asarray(decay.window.readings[mode.channel]))
            for decay, mode in zip(decays, modes, strict=True)
        )
        self.one_record = len(decays) == 1
        self.parts = cut_by_amplitude(self.whole[0]) if self.one_record else self.whole
        frequency = float(np.median(np.concatenate([curve.frequency for curve in self.whole])))
        duration = max(float(curve.time[-1]) for curve in self.whole)
        grid = amplitude_grid(self.whole)
        self.base = tuple(
            law_of(term, inner_of(term, known), frequency, grid, duration) for term in model.forces
        )
        closer = not self.one_record  # one curve alone is followed by any memory that may be chosen freely
        laws = (*self.base, *laws_of(terms, frequency, scales, grid, duration, closer=closer))
        varies = decays[0].window.varies
        if varies - {"damping"}:  # each release is at another frequency
            own = [float(np.median(curve.frequency)) for curve in self.whole]
            laws = tuple(
                replace(law, elsewhere=tuple(law_of(law.term, law.inner, w, grid, duration) for w in own))
                for law in laws
            )
        self.regression = CurveRegression(self.parts, laws, frequency, shares_of(varies))

    def laws_of_columns(self, columns: tuple[int, ...]) -> tuple[AveragedLaw, ...]:
        """Return the laws of some columns."""
        return tuple(self.regression.laws[c] for c in columns)

    def plausible(self, column: int, held: HeldOut) -> bool:
        """Whether no other effect is the better name for what a law became."""
        law = self.regression.laws[column]
        values = (
            law.term.held_values
            | law.inner
            | {law.term.effect.strength.name: float(held.strengths.shared[-1])}
        )
        return law.term.effect.plausible(values, self.scales)

    def hold_out(self, columns: tuple[int, ...], rows: Sequence[Rows]) -> HeldOut:
        """Return what some laws predict of each part from the others."""
        return hold_out(self.regression, columns, rows, one_record=self.one_record)

    def corrected(self, columns: tuple[int, ...], held: HeldOut) -> tuple[Rows, ...]:
        """Return what was measured, less what the windows and the averaging do to a motion of this model."""
        laws = self.laws_of_columns(columns)
        model = Model(tuple(law.term for law in laws))
        rows = []
        for i, (decay, mode) in enumerate(zip(self.decays, self.modes, strict=True)):
            strengths = held.strengths.of(i)
            values = self.known | values_of(laws, strengths)
            run = simulated_curve(decay, mode, model, values, self.whole[i])
            rows += self._less(columns, strengths, run, i)
        return tuple(rows)

    def _less(
        self, columns: tuple[int, ...], strengths: Array, run: DecayCurve | None, release: int
    ) -> list[Rows]:
        measured = self.regression.measured if self.one_record else (self.regression.measured[release],)
        if run is None:
            return list(measured)
        runs = self._cut(run) if self.one_record else (run,)
        less = []
        for rows, piece in zip(measured, runs, strict=True):
            excess = self.regression.excess(piece, columns, strengths)
            less.append(rows if excess is None else rows.minus(excess))
        return less

    def _cut(self, run: DecayCurve) -> tuple[DecayCurve, ...]:
        """Return a curve of the one record cut where the measured one is; neighbours have a point in common."""
        pieces, first = [], 0
        for part in self.parts:
            pieces.append(run.part(first, first + len(part)))
            first += len(part) - 1
        return tuple(pieces)

    def settled(self, columns: tuple[int, ...], rows: Sequence[Rows]) -> tuple[HeldOut, tuple[Rows, ...]]:
        """Return the errors of a model with its own corrections, and the corrected rows."""
        held, own = self.hold_out(columns, rows), tuple(rows)
        for _ in range(_ROUNDS):
            before, own = own, self.corrected(columns, held)
            held = self.hold_out(columns, own)
            if _moved(before, own) < _SETTLED * self.regression.typical_loss:
                break
        return held, own


def _moved(before: Sequence[Rows], after: Sequence[Rows]) -> float:
    """Return how far corrected rows have moved since the last round, rms, 1/s."""
    moved = [
        np.mean((a.loss - b.loss) ** 2 + (a.stiffness - b.stiffness) ** 2)
        for a, b in zip(before, after, strict=True)
    ]
    return float(np.sqrt(np.mean(moved)))
