"""Measured curves of one or more releases with the curves of models over them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from identify.arrays import Array
from identify.curves.decay_curve import AmplitudeCurve, DecayCurve
from identify.curves.isolated_mode import Isolated, isolated, simulated_curve
from identify.effects.force_effect import LinearPart
from identify.fitting.fit import Fit
from identify.fitting.segments import prepared_of
from identify.free_decay import FreeDecay
from identify.model.model import Model
from identify.model.parameter_id import values_in_release
from identify.preprocessing.prepared_decay import PreparedDecay

Role = Literal["usual", "named", "rival"]

_ROUNDS = 2


@dataclass(frozen=True, eq=False)
class Law:
    """A model with the values of its parameters by unknown's name; `role` says what it is to a diagnosis."""

    name: str
    role: Role
    model: Model
    values: dict[str, float]

    @classmethod
    def of(cls, name: str, role: Role, fit: Fit) -> "Law":
        """Take the law of a fit."""
        return cls.known(name, role, fit.model, {key: value.value for key, value in fit.parameters.items()})

    @classmethod
    def known(cls, name: str, role: Role, model: Model, values: dict[str, float]) -> "Law":
        """Take the law of a model's forces, without the faults of its sensors."""
        forces = Model(model.forces)
        known = {str(term.parameter(p.name)) for term in forces.terms for p in term.free}
        return cls(
            name, role, forces, {key: v for key, v in values.items() if key.partition("[")[0] in known}
        )


@dataclass(frozen=True, eq=False)
class LaidOver:
    """The curve of a law in the windows of each release, leaving out releases in which its motion diverges."""

    law: Law
    curves: tuple[AmplitudeCurve, ...]


@dataclass(frozen=True, eq=False)
class DecayCurves:
    """Measured curves of some releases, and laws laid over them; `unit` is the amplitude's, m or rad."""

    unit: str
    releases: tuple[AmplitudeCurve, ...]
    laws: tuple[LaidOver, ...] = ()


def decay_curves(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay], laws: Sequence[Law] = ()
) -> DecayCurves:
    """Compute frequency and damping against amplitude of one release or several, measured and by laws.

    A law is run freely from the start of each curve and seen through the same windows as the measurement. With several
    releases its linear spring and damper are set to each release, whose clamping and air are its own; the rest is
    shared. Releases that are too short are left out. Raises NotIdentifiable where all are, or where one is driven.
    """
    found = isolated(prepared_of(decays))
    several = len(found) > 1
    return DecayCurves(
        found[0].decay.window.unit,
        tuple(AmplitudeCurve.measured(one.curve, one.place) for one in found),
        tuple(LaidOver(law, _runs(found, law, own_linear=several)) for law in laws),
    )


def _runs(found: tuple[Isolated, ...], law: Law, *, own_linear: bool) -> tuple[AmplitudeCurve, ...]:
    curves = []
    for one in found:
        run = simulated_curve(one, law.model, values_in_release(law.values, one.place))
        for _ in range(_ROUNDS if own_linear else 0):
            if run is None:
                break
            own = _set_to(one.curve, run, law)
            again = simulated_curve(one, law.model, values_in_release(own.values, one.place))
            if again is None:
                break
            law, run = own, again
        if run is not None and np.isfinite(run.frequency).all():
            curves.append(AmplitudeCurve.predicted(run, one.place).down_to(float(one.curve.amplitude.min())))
    return tuple(curves)


def _set_to(measured: DecayCurve, run: DecayCurve, law: Law) -> Law:
    """Adjust the linear spring and damper of a law until its simulation has the measured mean loss and w^2."""
    values = dict(law.values)
    weight = measured.between**2 / np.sum(measured.between**2)
    lacks: tuple[tuple[LinearPart, Array], ...] = (
        (LinearPart.STIFFNESS, measured.frequency**2 - run.frequency**2),
        (LinearPart.DAMPING, measured.loss - run.loss),
    )
    for part, excess in lacks:
        term = next((t for t in law.model.forces if t.force.linear_part == part), None)
        if term is not None:
            name = str(term.strength)
            values[name] = max(values[name] + float(weight @ excess), term.effect.strength.low)
    return replace(law, values=values)
