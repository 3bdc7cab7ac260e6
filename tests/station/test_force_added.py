"""The force that a step of the ladder adds is that of the effect that it added."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from hidden import DUFFING, TRUTH

from daq.session import Session
from identify.diagnosis.force_map import force_added
from station.operations.refining import add, open_refinement, step_again
from station.settings import Settings


@pytest.fixture(scope="module")
def refinement(tmp_path_factory, diagnosed):
    settings = Settings(sessions=tmp_path_factory.mktemp("sessions"))
    session = Session.open(shutil.copytree(diagnosed, settings.sessions / DUFFING.stem))
    begun = open_refinement(session, settings)
    return replace(begun, ladder=add(begun, "cubic_stiffness"))


def test_the_force_map_of_a_cubic_spring_is_a_cubic_less_what_a_line_can_follow(refinement):
    base, top = (step_again(refinement, step).fit for step in refinement.ladder.steps)
    prepared = refinement.prepared
    added = force_added(prepared, base, top, top.model.terms[-1])
    u = prepared.motion.displacement
    truth = TRUTH[DUFFING.name]["parameters"]["k3"] * u**3
    used = np.abs(prepared.motion.velocity) > 0.05
    line = np.column_stack([u, prepared.motion.velocity, np.sign(prepared.motion.velocity), np.ones_like(u)])
    left = truth - line @ np.linalg.lstsq(line[used], truth[used], rcond=None)[0]
    # The regression along noisy motion finds k3 to some per cent; the two fits weigh the samples a little differently.
    assert np.abs((added - left)[used]).max() < 0.15 * np.abs(left[used]).max()
