"""The face of the package: one import, from two arrays to a named effect, and results that print themselves."""

import inspect
import subprocess
import sys

import numpy as np
import pytest

import identify
from mocks.generate import draw


@pytest.fixture(scope="module")
def decay() -> identify.FreeDecay:
    sample = draw("cubic_stiffness", 0.03, 5)
    return identify.FreeDecay(sample.rate, sample.displacement, sample.acceleration)


@pytest.fixture(scope="module")
def diagnosis(decay: identify.FreeDecay) -> identify.Diagnosis:
    return identify.diagnose(decay)


@pytest.fixture(scope="module")
def ladder(diagnosis: identify.Diagnosis) -> identify.Ladder:
    return diagnosis.refine()


def test_importing_the_package_imports_nothing_heavy():
    heavy = "[m for m in sys.modules if m.split('.')[0] in ('numpy', 'scipy', 'numba')]"
    run = subprocess.run(
        [sys.executable, "-c", f"import sys, identify; print({heavy})"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.strip() == "[]"


def test_the_library_loads_no_machine_code_and_nothing_of_scipy():
    """What each takes a start costs a twentieth of a second or more."""
    asked = (
        "import sys, identify; library = identify.LIBRARY; import identify.preprocessing.prepared_decay as _; "
        "functions = [f for e in library for n in ('force', 'friction', 'rates') if (f := getattr(e, n, None))]; "
        "heavy = ('fft', 'interpolate', 'linalg', 'ndimage', 'optimize', 'signal', 'special'); "
        "print(len(functions), sum(len(f.overloads) for f in functions), "
        "[n for n in heavy if f'scipy.{n}' in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    count, loaded, modules = run.stdout.strip().split(maxsplit=2)
    assert int(count) > 20
    assert (loaded, modules) == ("0", "[]")


def test_every_public_name_is_there_and_no_other():
    for name in identify.__all__:
        assert getattr(identify, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'read'"):
        identify.read  # noqa: B018


def test_what_a_notebook_shows_of_the_package_is_its_names_in_short_lines():
    assert dir(identify) == sorted(identify.__all__)
    for name in ("diagnose", "add_effect", "find_effect"):
        assert len(str(inspect.signature(getattr(identify, name)))) < 1000


def test_two_arrays_lead_to_the_hidden_effect_and_to_the_floor(
    diagnosis: identify.Diagnosis, ladder: identify.Ladder
):
    assert diagnosis.named == ("cubic_stiffness",)
    assert [step.at_floor for step in ladder.steps] == [False, True]
    assert ladder.steps[1].added == "cubic_stiffness"


def test_a_release_that_was_prepared_before_gives_the_same(decay: identify.FreeDecay):
    library = tuple(map(identify.find_effect, (*identify.base_model().names, "cubic_stiffness")))
    once = identify.diagnose(decay, library=library)
    again = identify.diagnose([identify.prepare(decay)], library=library)
    assert again.final.chi_square == pytest.approx(once.final.chi_square)


def test_both_methods_take_a_decay_whose_release_nobody_has_located(decay: identify.FreeDecay):
    located = identify.locate_and_align(decay)
    for method in (identify.identify_wavelet, identify.identify_restoring_force):
        assert method(decay).stiffness == method(located).stiffness


def test_every_result_prints_itself_in_a_screenful_and_as_a_table(
    decay: identify.FreeDecay, diagnosis: identify.Diagnosis, ladder: identify.Ladder
):
    results = (
        decay,
        identify.locate_and_align(decay),
        identify.prepare(decay),
        identify.identify_wavelet(decay),
        identify.identify_restoring_force(decay),
        identify.compare(decay),
        diagnosis,
        ladder,
    )
    for result in results:
        text = repr(result)
        assert text == str(result)
        assert text.count("\n") < 40
        assert "array(" not in text
        html = result._repr_html_()
        assert html.startswith("<b>")
        assert "<table>" in html


def test_a_strangers_text_in_a_summary_is_no_markup(decay: identify.FreeDecay):
    odd = decay.with_(unit="<b>m")
    assert "<b>m" not in odd._repr_html_().replace("<b>Free decay</b>", "")


def test_a_decay_of_noise_is_refused_in_words():
    noise = np.random.default_rng(0).standard_normal(2000)
    with pytest.raises(identify.NotIdentifiable, match="oscillat"):
        identify.diagnose(identify.FreeDecay(256.0, 1e-6 * noise, 0.01 * noise))
