"""Pictures that no test here looks at are laid out and not rendered: rendering took nine tenths of a capture."""

import base64
from io import BytesIO

import pytest

DOT = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a figure be saved as one dot."""

    def save(figure: object, buffer: BytesIO, **_: object) -> None:
        buffer.write(DOT)

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", save)
