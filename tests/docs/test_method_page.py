"""The page of the method says what the code does: its constants, its closed forms, its verdicts."""

import importlib
import re
from math import pi
from typing import get_args

import pytest
from contracts import ROOT

from identify.judging.verdict import Verdict
from identify.signal.averaging import backbone_factors, envelope_factors

PAGE = " ".join((ROOT / "docs" / "method.md").read_text(encoding="utf-8").split())
WORDS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six", 12: "twelve"}


def value(module, name):
    return getattr(importlib.import_module(f"identify.{module}"), name)


@pytest.mark.parametrize(
    ("module", "name", "said"),
    [
        ("preprocessing.release", "HAND_S", lambda x: f"begin {1e3 * x:g} ms later"),
        ("preprocessing.noise", "SHORTEST_REST", lambda x: f"at least {x} samples at rest"),
        ("signal.order_selection", "CLEAR", lambda x: f"stands {WORDS[x]} standard errors from zero"),
        ("signal.weak_form", "WINDOW_CYCLES", lambda x: f"{WORDS[x]} cycles long"),
        ("signal.weak_form", "ROWS_PER_CYCLE", lambda x: f"{WORDS[x]} starts a cycle"),
        ("wavelet.ridge", "WIDTH_CYCLES", lambda x: "standard deviation is one cycle" if x == 1 else "?"),
        ("fitting.fit", "_GROWTH", lambda x: f"grows over {', '.join(f'{n:g}' for n in x)} cycles"),
        ("fitting.baseline", "_BAND_ABOVE", lambda x: "above eight times" if x == 8 else "?"),
        ("priors", "ADEQUATE", lambda x: rf"\max({x:g}\,\sigma_{{\text{{floor}}}}"),
        ("priors", "BENEFIT_OF_DOUBT", lambda x: f"and {x:g} if it had to be guessed"),
        ("priors", "SPEAKS_AGAINST", lambda x: rf"only if $p \ge {x:g}$"),
        ("fitting.segments", "_LONG_CYCLES", lambda x: f"more than {x:g} cycles"),
        ("fitting.segments", "_DRIFTING_CYCLES", lambda x: f"of {WORDS[x]} cycles or more"),
        ("fitting.segments", "_MOST", lambda x: f"at most {WORDS[x]}. Whether"),
        ("fitting.segments", "_MOST_CYCLES", lambda x: f"of more than {x:g} cycles as many"),
        ("preprocessing.averaged_decay", "BLOCKS_A_CYCLE", lambda x: f"to {x} to {2 * x} a cycle"),
        ("preprocessing.averaged_decay", "FEW", lambda x: f"more than {x} samples"),
        (
            "fitting.corrected_faults",
            "UNSTATED_GAIN_UNCERTAINTY",
            lambda x: f"unstated, that is {100 * x:g} %",
        ),
        ("priors", "DOUBT", lambda x: f"the probability of none exceeds {100 * x:g} %"),
        ("priors", "DOUBT_AT_A_GUESS", lambda x: rf"${1e4 * x:g}\cdot10^{{-4}}$"),
        ("priors", "RIVALS_WITHIN", lambda x: f"within {x:.1f} nats of each other"),
        (
            "judging.floor_not_reached",
            "_LINE_LEAVES",
            lambda x: f"leaves less than {100 * x:g} % of chi-square",
        ),
        ("priors", "DOUBT", lambda x: f"leave out {100 * x:g} % of the probability"),
        ("priors", "MOST_ALIKE", lambda x: f"of any {WORDS[x]} laws below"),
        ("priors", "LARGE", lambda x: "remove half a percent of the motion" if x == 0.5 else "?"),
        ("priors", "LEAVES", lambda x: "leave two fifths at most" if x == 0.4 else "?"),
        ("priors", "FEWEST_CYCLES", lambda x: f"fewer than {WORDS[x]} cycles"),
        (
            "priors",
            "STIFFNESS_VARIES",
            lambda x: rf"normal priors of {100 * x:g} % of $\omega_0^2$",
        ),
        ("priors", "DAMPING_VARIES", lambda x: f"and of {100 * x:g} % of the mean loss"),
        ("judging.search", "_FITTED", lambda x: f"the {WORDS[x]} best are fitted"),
        ("diagnosis.ladder", "_STILL_NEEDED", lambda x: rf"no longer lowers $\chi^2$ by {x:g}"),
    ],
)
def test_a_number_on_the_page_is_that_of_the_code(module, name, said):
    assert said(value(module, name)) in PAGE


def test_the_factors_of_the_envelope_are_the_four_closed_forms_of_the_page():
    forms = re.search(r"so that (\$c_0.*?\$) \(`envelope_factors`\)", PAGE)[1]
    assert forms == (
        r"$c_0 = 2\mu_0/(\pi\omega_0)$, $c_1 = \mu_1/2$, $c_2 = 4\omega_0\mu_2/(3\pi)$, $c_3 = 3\omega_0^2\mu_3/8$"
    )
    w = 24.8
    expected = [2 / (pi * w), 1 / 2, 4 * w / (3 * pi), 3 * w**2 / 8]
    assert envelope_factors(w, 3) == pytest.approx(expected, rel=1e-12)  # rounding only


def test_the_factors_of_the_backbone_are_those_of_the_page():
    assert r"= 1,\ \tfrac{3}{4},\ \tfrac{5}{8}" in PAGE
    assert backbone_factors((1, 3, 5)) == pytest.approx([1, 3 / 4, 5 / 8], rel=1e-12)  # rounding only


def test_every_verdict_has_its_row():
    assert set(re.findall(r"\| `(\w+)` \| [a-z]", PAGE)) >= set(get_args(Verdict))
