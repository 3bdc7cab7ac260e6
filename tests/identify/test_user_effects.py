"""Effects of the user's own: what is read, what is refused and where, and that they take part like the library's."""

import math

import numpy as np
import pytest
from releases import drawn
from scipy.integrate import solve_ivp
from specimens import FEW

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.ladder import add_effect, first_step
from identify.effects.effect import Parameter, Scales
from identify.effects.user import build, own_effect, parse_effect
from identify.fitting.baseline import fit_baseline
from identify.judging.suspects import try_terms
from identify.model.model import Term, base_model
from identify.model.simulate import make_system, simulate
from station.exits import UsageProblem
from station.own_effects import load_effects

P = (0.7, 0.4, 1.3, 0.0, 0.0, 0.0)
REST = (0.0, 0.0)
SCALES = Scales(0.02, 24.78, 8.0, 256.0, {}, {"acceleration": ((50.0, 0.1, 0.0),)})


@pytest.mark.parametrize(
    ("formula", "closed"),
    [
        ("a*u/(1+(u/b)**2)", lambda t, u, v, a, b: a * u / (1 + (u / b) ** 2)),
        ("a*exp(-t/b)*u", lambda t, u, v, a, b: a * math.exp(-t / b) * u),
        ("-a*-u", lambda t, u, v, a, b: a * u),
        ("a*(2 + u)**-1*sin(u)", lambda t, u, v, a, b: a * math.sin(u) / (2 + u)),
        ("a*2**-u**2 - a", lambda t, u, v, a, b: a * (2 ** -(u**2) - 1)),
        ("a*clip(v, -b, b)*tanh(t)", lambda t, u, v, a, b: a * max(-b, min(v, b)) * math.tanh(t)),
        ("a*abs(u)**b*sgn(u)", lambda t, u, v, a, b: a * abs(u) ** b * (1 if u > 0 else -1)),
        ("a*(min(u, v) + max(u, b*v))", lambda t, u, v, a, b: a * (min(u, v) + max(u, b * v))),
        ("a*log(1 + u*u/b)*sqrt(abs(v))*cos(u)", lambda t, u, v, a, b: a * math.log(1 + u * u / b)
         * math.sqrt(abs(v)) * math.cos(u)),
        ("a*sin(2*pi*t)*1e-3/.5", lambda t, u, v, a, b: a * math.sin(2 * math.pi * t) * 2e-3),
    ],
)  # fmt: skip
def test_a_formula_gives_what_it_says(formula, closed):
    effect = parse_effect(f"own = {formula}")
    for t, u, v in ((0.4, 0.013, -0.21), (0.1, -0.5, 0.3), (2.0, 0.9, 0.01)):
        assert effect.force(t, u, v, REST, P) == pytest.approx(closed(t, u, v, 0.7, 0.4), rel=1e-13)


@pytest.mark.parametrize(
    ("text", "strength", "inner"),
    [
        ("x = a*u/(1 + (u/b)**2)", "a", ("b",)),
        ("x = tanh(u/b)*c", "c", ("b",)),
        ("x = u**3", "scale", ()),
        ("x = tanh(u/scale)", "strength", ("scale",)),
        ("x = max(k*(u - gap), 0)", "k", ("gap",)),
        ("x = q*exp(-((u - at)/tan1)**2)", "q", ("at", "tan1")),
        ("x = a*u + u**3", "scale", ("a",)),
    ],
)
def test_the_parameter_that_the_force_follows_in_proportion_is_the_strength(text, strength, inner):
    effect = parse_effect(text)
    assert (effect.strength.name, effect.inner) == (strength, inner)
    once = effect.force(0.3, 0.5, 0.2, REST, (1.0, 0.3, 0.4, 0.0, 0.0, 0.0))
    assert once != 0.0
    assert effect.force(0.3, 0.5, 0.2, REST, (3.0, 0.3, 0.4, 0.0, 0.0, 0.0)) == pytest.approx(3.0 * once)


def test_a_force_that_is_proportional_from_zero_up_only_has_its_strength_bounded_there():
    assert parse_effect("x = max(k*(u - gap), 0)").strength.low == 0.0
    assert parse_effect("x = k*max(u - gap, 0)").strength.low == -math.inf


@pytest.mark.parametrize(
    ("text", "level", "force"),
    [
        ("x = a*sgn(v)", 0.7, 0.0),
        ("x = a*u + a*b*sgn(v)", 0.28, 0.7 * 0.013),
        ("x = a*u*sgn(v)**2", 0.0, 0.7 * 0.013),
        ("x = max(a*sgn(v), 0)", 0.35, 0.35),
        ("x = a*exp(-abs(v)/b)*sgn(v)", 0.7 * math.exp(-0.21 / 0.4), 0.0),
        ("x = a*(1 + sgn(u))/2*sign(v)", 0.7, 0.0),
    ],
)
def test_what_goes_with_the_sign_of_v_is_a_level_of_friction_and_the_rest_a_force(text, level, force):
    effect = parse_effect(text)
    assert effect.friction(0.4, 0.013, -0.21, REST, P) == pytest.approx(level, rel=1e-13)
    assert effect.force(0.4, 0.013, -0.21, REST, P) == pytest.approx(force, rel=1e-13)


def test_a_friction_of_ones_own_sticks_where_coulombs_does():
    own = make_system((parse_effect("grip = m*sgn(v)"),))
    table = np.zeros((1, 6))
    table[0, 0] = 0.13
    common = {"start": (0.02, 0.0), "samples": 4096, "rate": 256.0, "substeps": 4}
    mine = simulate(own, np.array([614.0, 0.277, 0.0]), table, states=np.zeros((1, 2)), **common)
    theirs = simulate(
        make_system(()),
        np.array([614.0, 0.277, 0.13]),
        np.zeros((0, 6)),
        states=np.zeros((0, 2)),
        **common,
    )
    np.testing.assert_allclose(mine.displacement, theirs.displacement, atol=1e-15)
    assert mine.acceleration[-1] == 0.0
    assert mine.displacement[-1] != 0.0


HOSTILE = [
    "x = __import__('os').system('true')",
    "x = (lambda: u)()",
    "x = u.__class__",
    "x = u.real",
    "x = [u][0]",
    "x = {u}",
    "x = f'{u}'",
    "x = a*u if u else v",
    "x = u and v",
    "x = not u",
    "x = u is v",
    "x = a*u@v",
    "x = a*u//v",
    "x = a*u%v",
    "x = ~u",
    "x = a*u^2",
    "x = a*u < 0",
    "x = (a := u)",
    "x = exec(u)",
    "x = eval(u)",
    "x = sin(u)(v)",
    "x = sin(*u)",
    "x = a*sin(**u)",
    "x = a*sin(x=u)",
    "x = sin(u, v)",
    "x = max(u)",
    "x = a*sin",
    "x = a*u**99",
    "x = a*u**-99",
    "x = a*u**(9**9**9)",
    "x = 9**9**9*a*u",
    "x = a*u*1e999",
    "x = a*u*" + "9" * 350,
    "x = a*1j*u",
    "x = a*True*u",
    "x = a*u\x00",
    "x = a*u\nimport os",
    "x = a*u # comment",
    "x = a*u*µ",
    "x = a*(u",
    "x = a*u)",
    "x = a u",
    "x = a*",
    "x = a*_u",
    "x = __builtins__*a",
    "x = " + "(" * 150 + "u",
    "x = " + "-" * 300 + "a*u",
    "x = " + "tan(" * 80 + "u" + ")" * 80,
    "x = " + "a*u+" * 200 + "u",
    "x = " + "a*u;" * 2000,
    "x = a*b*c*d*e1*f*g*u",
    "",
    "=",
    "x",
    "x =",
    "= a*u",
    "2x = a*u",
    "x y = a*u",
    "t = a*u",
    "sin = a*u",
    "cubic_stiffness = a*u",
]


@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: text[:24].replace("\x00", "0"))
def test_what_is_no_formula_is_refused_in_one_sentence_and_compiles_nothing(text, monkeypatch):
    compiled = []
    monkeypatch.setattr(build, "effect_function", lambda *given, **how: compiled.append(given))
    with pytest.raises(ValueError, match=r"\w \w") as refused:
        parse_effect(text)
    assert "\n" not in str(refused.value)
    assert not compiled


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("magnet = a*u^2", 13),
        ("magnet = a*foo(u)", 12),
        ("  magnet =  a*u**99", 18),
        ("x = a*u*z0", 9),
        ("x = a*sgn(u - v)", 7),
        ("x = a*u; b: m", 10),
        ("x = a*u; a: mm", 13),
        ("x = a*u; a = 3..1", 12),
        ("x = a*u; a = 3-4", 15),
        ("x = a*u*b; b: m = 0..1 start 0.3, 2", 30),
        ("x = a*u*b; b start", 19),
        ("x = a*u*b; b 3", 14),
        ("x = a*u; a: m; a: m", 16),
        ("x = (a*u", 5),
    ],
)
def test_a_refusal_says_where(text, place):
    with pytest.raises(ValueError, match=rf"\bcharacter {place}:"):
        parse_effect(text)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("x = a*sqrt(u)", "gives no number"),
        ("x = a/u", "u = 0"),
        ("x = a*v/abs(v)", r"v/abs\(v\) is sgn\(v\)"),
        ("x = a*u**b", r"abs\(u\)\*\*b"),
        ("x = a", "constant force"),
        ("x = 0*a*u", "zero everywhere"),
        ("x = a*u + 0*b", "b has no influence"),
        ("x = a*b*u", "a, b act only together"),
        ("x = a*exp(b*c*u)*u", "b, c act only together"),
        ("x = a*u + b*v", "strength of its own"),
        ("x = a*sgn(v - b)", r"sgn\(v\) alone"),
    ],
)
def test_a_force_that_cannot_be_fitted_is_refused_with_the_reason(text, why):
    with pytest.raises(ValueError, match=why):
        parse_effect(text)


@pytest.mark.parametrize(
    "text",
    [
        "x = c*v*(1 + sgn(abs(u) - at))/2; at: m >= 0",
        "x = q*exp(-((u - at)/w)**2); w: m = 0.0005..0.002",
        "x = a*log(1 + u/b)",
        "x = m*exp(-t/T)*sgn(v); T: s >= 0.1",
        "x = a*u*sin(2*pi*f*t + ph); f: Hz; ph: rad",
    ],
)
def test_parameters_that_show_only_here_or_there_are_not_called_useless(text):
    assert len(parse_effect(text).parameters) >= 2


def test_a_setting_gives_unit_bounds_and_starts():
    effect = parse_effect(
        "x = a*u/(1 + (u/b)**2); a: 1/s^2 = -5..5 start 1; b: m >= 0.001 <= .02 start 2e-3, 0.01"
    )
    assert [(p.name, p.unit, p.low, p.high) for p in effect.parameters] == [
        ("a", "1/s^2", -5.0, 5.0),
        ("b", "m", 0.001, 0.02),
    ]
    assert effect.starts(SCALES) == ((2e-3,), (0.01,))


def test_starts_are_spread_over_the_scales_of_the_data():
    def of(settings):
        effect = parse_effect(f"x = a*u*exp(-(u*v*t/b)**2); {settings}")
        return sorted(start[0] for start in effect.starts(SCALES))

    assert of("b: m") == pytest.approx([0.002, 0.006, 0.012])
    assert of("b: m/s") == pytest.approx([share * 0.02 * 24.78 for share in (0.1, 0.3, 0.6)])
    period = 2.0 * math.pi / 24.78
    assert of("b: s")[:3] == pytest.approx([0.3 * period, period, 3.0 * period])
    assert of("b: m^2 s") == pytest.approx([share * 0.02**2 / 24.78 for share in (0.3, 1.0, 3.0)])
    assert all(5.0 <= value <= 6.0 for value in of("b: m = 5..6"))
    assert 50.0 in {s[0] for s in parse_effect("x = a*sin(2*pi*f*t)*u; f: Hz").starts(SCALES)}
    agnostic = parse_effect("x = a*u*exp(-(u/b)**2)")
    assert "no unit" in agnostic.parameters[1].meaning
    tried = [s[0] for s in agnostic.starts(SCALES)]
    assert all(any(v == pytest.approx(size) for v in tried) for size in (0.006, 0.3 * 0.02 * 24.78, 1.0))


def test_a_place_is_looked_for_on_both_sides_and_a_width_on_one():
    starts = parse_effect("x = q/(1 + ((u - at)/w)**2); at: m; w: m").starts(SCALES)
    assert min(at for at, _ in starts) < 0.0 < max(at for at, _ in starts)
    assert min(w for _, w in starts) > 0.0


def test_many_parameters_do_not_make_many_starts():
    effect = parse_effect("x = a*u*exp(-(u/b)**2 - abs(v)/c - t/d)*cos(u/g)")
    assert len(effect.starts(SCALES)) <= 48


def test_a_formula_is_compiled_once_for_its_force_and_once_for_its_friction(monkeypatch):
    compiled, compile_force = [], build.effect_function

    def counting(function, **how):
        compiled.append(function)
        return compile_force(function, **how)

    monkeypatch.setattr(build, "effect_function", counting)
    parse_effect("x = a*u/(1 + (u/b)**2)*exp(-abs(v)/c)*sgn(v) + a*sin(u)")
    assert len(compiled) == 2


def test_memory_of_ones_own_starts_at_rest_and_runs_as_an_independent_integrator_says():
    creep = own_effect("creep", "k1*(u - z0)", rates=("(u - z0)/tau",))
    assert creep.fading_memory
    assert creep.equilibrium_state(0.02, np.array([60.0, 0.05, 0, 0, 0, 0])) == pytest.approx(
        (0.02, 0.0), abs=1e-12
    )
    table = np.array([[60.0, 0.05, 0, 0, 0, 0]])
    found = simulate(
        make_system((creep,)),
        np.array([614.0, 0.277, 0.0]),
        table,
        start=(0.02, 0.0),
        states=np.array([[0.02, 0.0]]),
        samples=512,
        rate=256.0,
        substeps=4,
    )
    t = np.arange(512) / 256.0
    exact = solve_ivp(
        lambda t, y: [y[1], -614.0 * y[0] - 0.277 * y[1] - 60.0 * (y[0] - y[2]), (y[0] - y[2]) / 0.05],
        (0.0, t[-1]),
        [0.02, 0.0, 0.02],
        t_eval=t,
        rtol=1e-10,
        atol=1e-14,
        method="DOP853",
    )
    assert np.max(np.abs(found.displacement - exact.y[0])) < 1e-7  # the simulator's own accuracy


def test_a_memory_that_keeps_what_it_was_is_told_from_one_that_forgets():
    slip = own_effect("slip", "kh*z0", rates=("v*(1 - (z0/uy)**2*(1 + sgn(v*z0))/2)",))
    assert not slip.fading_memory


@pytest.mark.parametrize(
    ("hidden", "strength", "text"),
    [
        ("magnet", 0.01, "own = q/(1 + ((u - at)/width)**2)"),
        pytest.param(
            "notched_spring",
            0.01,
            "own = -q*((u - at)/w)*exp(-((u - at)/w)**2); at: m; w: m >= 0.0003",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_what_no_library_has_is_named_by_the_users_own_effect_and_reaches_the_floor(hidden, strength, text):
    setting, truth = drawn(hidden, strength, seed=61)
    found = diagnose((setting,), library=(*FEW, parse_effect(text)))
    assert found.verdict == "missing_effect"
    assert found.named == ("own",)
    assert 0.85 < found.final.reduced < 1.15  # the floor of one record is known to some 5 %
    for estimate, true in zip(
        found.suspects[0].parameters.values(), truth["parameters"].values(), strict=True
    ):
        # A width's sign does not matter; 4.5 standard errors are left behind once in 10^5.
        assert min(abs(estimate.value - true), abs(estimate.value + true)) < 4.5 * estimate.std


def test_memory_of_ones_own_takes_part_and_is_found():
    setting, truth = drawn("maxwell_element", 0.02, seed=62)
    creep = own_effect(
        "creep",
        "k1*(u - z0)",
        rates=("(u - z0)/tau",),
        parameters=(Parameter("k1", "1/s^2", "", 0.0), Parameter("tau", "s", "", 1e-3, 10.0)),
    )
    base = fit_baseline((setting,), base_model()).fit
    (found,) = try_terms((setting,), base, (Term(creep),))
    tau = found.fit.values["creep.tau"]
    assert abs(tau.value - truth["parameters"]["tau"]) < 4.5 * tau.std
    assert found.fit.reduced < 1.2


def test_a_formula_can_be_added_by_hand_and_the_error_falls_to_the_floor():
    setting, _ = drawn("one_way_cable", 0.01, seed=63)
    ground = first_step((setting,))
    added = add_effect(ground, parse_effect("cable = kc*max(u, 0)*(1 + sgn(v))/2"))
    assert added.error.chi_square < 1.2 < ground.error.chi_square


GOOD = """
from identify.effects.effect import Parameter
from identify.effects.force_effect import ForceEffect
from identify.effects.user import own_effect

def pull(t, u, v, z, p):
    return p[0] * u / (1.0 + (u / p[1]) ** 2)

EFFECTS = (
    ForceEffect(
        name="magnet",
        title="a magnet",
        equation="a u/(1 + (u/b)^2)",
        parameters=(Parameter("a", "1/s^2", "stiffness"), Parameter("b", "m", "reach")),
        force=pull,
        starts=lambda scales: ((0.002,), (0.01,)),
        symptom="softer at large amplitude",
        confirming_test="take the magnet away",
    ),
    own_effect("creep", "k1*(u - z0)", rates=("(u - z0)/tau",)),
)
"""


def test_a_file_of_effects_is_read(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(GOOD)
    effects = load_effects(file)
    assert [e.name for e in effects] == ["magnet", "creep"]
    assert effects[0].starts(SCALES) == ((0.002,), (0.01,))
    assert effects[0].force_along(P, *np.array([[0.0], [0.01], [0.0]]), np.zeros((1, 2))) == pytest.approx(
        0.7 * 0.01 / (1.0 + (0.01 / 0.4) ** 2), rel=1e-14
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("EFFECTS = (", r"mine\.py, line 1: SyntaxError"),
        ("\nx = 1/0\n", r"mine\.py, line 2: ZeroDivisionError"),
        ("from identify.effects.user import own_effect\n\nEFFECTS = (own_effect('x', 'a*u^2'),)", r"line 3: x: force, char"),
        ("from identify.effects.user import own_effect\nEFFECTS = (own_effect('x', lambda t, u, v, a: a*u),)", "line 2: x"),
        ("pass", "it defines no effects"),
        ("EFFECTS = ()", "it defines no effects"),
        ("EFFECTS = (3,)", "entry 1 of EFFECTS is int"),
        ("raise SystemExit", "line 1: it ends the program"),
        ("from nowhere_at_all import x", "ModuleNotFoundError"),
        (GOOD + "\nEFFECTS = EFFECTS[:1] * 2", "another effect is called magnet too"),
        ("x = '\0'", "mine.py"),
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_used_is_refused_in_a_sentence_with_the_line(tmp_path, text, said):
    file = tmp_path / "mine.py"
    file.write_text(text)
    with pytest.raises(UsageProblem, match=said) as refused:
        load_effects(file)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_is_refused_by_its_name(tmp_path):
    with pytest.raises(UsageProblem, match=r"none\.py cannot be read"):
        load_effects(tmp_path / "none.py")


def test_a_force_too_large_to_be_squared_is_no_fault_of_the_program():
    # Found by fuzzing: a warning is an error here, and none may come.
    with pytest.raises(ValueError, match="b has no influence"):
        parse_effect("x = a*u*exp(400) + b*v")
