"""The families: laws between the effects of the library, with a free parameter: suspects where a member is claimed."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from math import copysign, exp

from identify.effects.effect import Effect, Parameter, Scales
from identify.effects.force_effect import ForceEffect
from identify.effects.joint import DAHL_FRICTION, STIFFNESS, YIELD, joint


@dataclass(frozen=True, eq=False, kw_only=True)
class Family:
    """A law with a free parameter, for shapes between the names: "behaves like quadratic_damping, p = 1.9 +- 0.1".

    `effect` is fitted as any other force; `free` names that parameter. `members` gives its value at which the law is an
    effect of the library, by that effect's name. `held(scales)` are the inner parameters to hold in a fit, chosen so that
    strength and exponent are hardly correlated.
    """

    effect: ForceEffect
    free: str
    members: Mapping[str, float]
    held: Callable[[Scales], dict[str, float]] = field(default=lambda scales: {})

    def nearest(self, value: float, beside: Collection[str] = ()) -> str | None:
        """Return the member whose value is nearest to a given one, of those that are not `beside` it; None for none."""
        others = (name for name in self.members if name not in beside)
        return min(others, key=lambda name: abs(self.members[name] - value), default=None)


POWER_LAW_STIFFNESS = Family(
    effect=ForceEffect(
        name="power_law_stiffness",
        title="spring of a power law",
        equation="f (|u|/at)^p sgn u",
        parameters=(
            Parameter("f", "m/s^2", "force per unit mass at the displacement `at`"),
            Parameter("p", "1", "exponent", 1.2, 7.0),
            Parameter("at", "m", "displacement at which the force is f", 0.0),
        ),
        force=lambda t, u, v, z, p: p[0] * copysign((abs(u) / p[2]) ** p[1], u),
        starts=lambda scales: ((1.5,), (2.5,), (4.5,)),
        variants=({"at": 1.0},),
        symptom="the frequency moves with the power p - 1 of the amplitude, alike in both directions",
        confirming_test="release from twice the amplitude: the frequency shift grows by 2^(p - 1)",
    ),
    free="p",
    members={"signed_quadratic_stiffness": 2.0, "cubic_stiffness": 3.0, "quintic_stiffness": 5.0},
    held=lambda scales: {"at": scales.amplitude},
)


POWER_LAW_DAMPING = Family(
    effect=ForceEffect(
        name="power_law_damping",
        title="damping of a power law",
        equation="f (|v|/at)^p sgn v",
        parameters=(
            Parameter("f", "m/s^2", "force per unit mass at the speed `at`", 0.0),
            Parameter("p", "1", "exponent", 0.2, 4.0),
            Parameter("at", "m/s", "speed at which the force is f", 0.0),
        ),
        force=lambda t, u, v, z, p: p[0] * copysign((abs(v) / p[2]) ** p[1], v),
        starts=lambda scales: ((0.5,), (1.6,), (2.6,)),
        variants=({"at": 1.0},),
        symptom="the decrement grows with the power p - 1 of the amplitude",
        confirming_test="release from twice the amplitude: the extra decrement grows by 2^(p - 1)",
        nonsmooth=True,
    ),
    free="p",
    members={"viscous_damping": 1.0, "quadratic_damping": 2.0, "cubic_damping": 3.0},
    held=lambda scales: {"at": scales.speed},
)


def _joint_rates(t, u, v, z, p):  # type: ignore[no-untyped-def]
    if p[1] <= 0.0:
        return 0.0, 0.0
    if v * z[0] > 0.0:
        return v * (1.0 - abs(z[0]) ** p[2]) / p[1], 0.0
    return v / p[1], 0.0


BOUC_WEN = Family(
    effect=joint(
        name="bouc_wen_hysteresis",
        title="hysteresis of Bouc and Wen",
        equation="kh uy z,  z' = (v/uy) (1 - |z|^n [v z > 0])",
        parameters=(
            STIFFNESS,
            YIELD,
            Parameter("n", "1", "sharpness of the yield", 0.5, 4.0),
        ),
        rates=_joint_rates,
        starts=lambda scales: tuple(
            (share * scales.amplitude, n) for share in (0.1, 0.25, 0.6) for n in (1.0, 2.5)
        ),
        gives_way=lambda p: float(p[1] / p[2]),
        symptom="a loop in the plane of displacement and force; a larger n gives it sharper corners",
        confirming_test="move the mass slowly to and fro: the loop shows its corners",
    ),
    free="n",
    members={"hysteresis": 2.0},
)


_MOST_RISE = 3.0


def _lugre_rates(t, u, v, z, p):  # type: ignore[no-untyped-def]
    if p[1] <= 0.0:
        return 0.0, 0.0
    rise = p[2] * exp(-(v / p[3]) * (v / p[3])) if p[3] > 0.0 else 0.0
    return (v - abs(v) * z[0] / (1.0 + rise)) / p[1], 0.0


LUGRE = Family(
    effect=joint(
        name="lugre_friction",
        title="friction that gives way, and falls with the speed (LuGre)",
        equation="kd ud z,  z' = (v/ud) (1 - z sgn v/(1 + rise exp(-(v/vs)^2)))",
        parameters=(
            *DAHL_FRICTION.parameters,
            Parameter("rise", "1", "extra friction at rest, over the friction kd ud", 0.0, _MOST_RISE),
            Parameter("vs", "m/s", "speed at which it has fallen to 1/e", 0.0),
        ),
        rates=_lugre_rates,
        largest_state=1.0 + _MOST_RISE,
        starts=lambda scales: tuple(
            (ud * scales.amplitude, rise, vs * scales.speed)
            for ud in (0.03, 0.06, 0.1, 0.16, 0.25)
            for rise in (0.3, 0.8)
            for vs in (0.1, 0.2, 0.35, 0.6)
        ),
        gives_way=DAHL_FRICTION.gives_way,
        symptom="friction that rises gradually after each reversal, and falls again where the mass is quick",
        confirming_test="move the mass by less than ud, slowly: it springs back; quicker it slides more easily",
    ),
    free="rise",
    members={"dahl_friction": 0.0},
)
"""Canudas de Wit, Olsson, Astrom and Lischinsky (1995), without the damping of their bristles."""

FAMILIES: tuple[Family, ...] = (POWER_LAW_STIFFNESS, POWER_LAW_DAMPING, BOUC_WEN, LUGRE)

FAMILY_OF: dict[Effect, Family] = {family.effect: family for family in FAMILIES}
