"""What the tests of the station share: a session that was diagnosed once; a viewer's library that is strict."""

import os
from pathlib import Path

import pytest
from hidden import DUFFING

from station.cli import run

os.environ["RERUN_STRICT"] = "1"  # wrong arguments to the viewer's library raise instead of warning


@pytest.fixture(scope="session")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of the release with a Duffing spring, diagnosed; copy it before anything is done to it."""
    made = tmp_path_factory.mktemp("diagnosed")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        patch.setattr("station.views.viewer.PORT", 9)  # nobody listens there
        assert run(["diagnose", str(DUFFING), "--no-viewer"]) == 0
    return made / "sessions" / DUFFING.stem
