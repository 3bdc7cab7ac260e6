"""Other sources: a file that grows, a sound card (its library replaced), a class of one's own."""

import sys
import threading
import time
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from printing_board import RATE, as_csv, release

from daq.capture import CaptureSettings, capture
from daq.errors import LinkLost, OperatorError, PortError
from daq.sources import SourceBoard
from daq.sources.open_source import GrowingFile, LineOptions, open_lines, open_source

SETTINGS = CaptureSettings(duration_s=4.0, rest_s=0.5, check_clock=False)

OWN = """
import numpy as np
from daq.recording import Channel
from daq.sources import Reading, SourceDescription

class Card:
    def __init__(self):
        self.at = 0
        self.closed = False
        self.data = np.load({file!r})
    def describe(self):
        channels = (Channel("x", "displacement", "m"), Channel("a", "acceleration", "m/s^2"))
        return SourceDescription("my card", channels, 256.0)
    def start(self):
        self.at = 0
    def read(self):
        first, self.at = self.at, min(self.at + 50, len(self.data))
        return [Reading(first, self.data[first:self.at])]
    def close(self):
        self.closed = True
"""


def test_a_class_of_ones_own_is_captured(tmp_path):
    displacement, acceleration, _ = release()
    np.save(tmp_path / "d.npy", np.column_stack([displacement, acceleration]))
    (tmp_path / "card.py").write_text(OWN.format(file=str(tmp_path / "d.npy")))
    source = open_source(f"{tmp_path / 'card.py'}:Card", LineOptions())
    recording = capture(SourceBoard(source), SETTINGS, tmp_path / "s").recording()
    found = recording.channel("displacement")
    assert recording.rate == RATE
    assert recording.valid.all()
    at = next(i for i in range(len(displacement)) if np.array_equal(displacement[i : i + 50], found[:50]))
    np.testing.assert_array_equal(found, displacement[at : at + len(found)])
    assert source.closed


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("nothing", "'nothing' is no source"),
        ("nowhere.py:Card", "is no source"),
        ("{folder}/broken.py:Card", "broken.py: ZeroDivisionError"),
        ("{folder}/lacks.py:Card", "Card lacks read, close"),
        ("{folder}/lacks.py:Other", "has no class Other"),
    ],
)
def test_what_is_no_source_is_refused_in_a_sentence(tmp_path, text, says):
    (tmp_path / "broken.py").write_text("1 / 0\n")
    (tmp_path / "lacks.py").write_text("class Card:\n    def describe(self): ...\n    def start(self): ...\n")
    with pytest.raises(OperatorError, match=says):
        open_source(text.format(folder=tmp_path), LineOptions())


def test_what_is_added_to_a_file_is_read_and_what_was_there_is_not(tmp_path):
    file = tmp_path / "log.txt"
    file.write_text("old\n")
    port = GrowingFile(file)
    assert port.read() == b""
    with file.open("a") as more:
        more.write("new\n")
    assert port.read() == b"new\n"
    file.write_text("")
    with pytest.raises(LinkLost, match="cut off"):
        port.read()
    port.close()
    with pytest.raises(PortError, match="cannot be read"):
        GrowingFile(tmp_path / "none.txt")


@pytest.mark.slow
def test_lines_of_a_growing_file_become_samples(tmp_path):
    displacement, acceleration, _ = release()
    file = tmp_path / "log.csv"
    file.write_text("time [ms],position [um],acc [m/s^2]\n")
    stop = threading.Event()

    def write():
        with file.open("a") as out:
            for line in as_csv(np.tile(displacement, 9), np.tile(acceleration, 9)):
                if stop.is_set():
                    return
                out.write(line + "\n")
                out.flush()
                time.sleep(0.0005)

    writer = threading.Thread(target=write)
    writer.start()
    try:
        options = LineOptions(None, {"time": 1, "displacement": 2, "acceleration": 3},
                              {"time": "ms", "displacement": "um", "acceleration": "m/s^2"})  # fmt: skip
        source = open_lines(str(file), options)
        source.start()
        until = time.monotonic() + 10.0
        samples = []
        while len(samples) < 60 and time.monotonic() < until:
            samples += [row for reading in source.read() for row in reading.samples.tolist()]
    finally:
        stop.set()
        writer.join()
        source.close()
    assert len(samples) >= 60
    printed = np.concatenate([displacement, displacement[:60]])
    found = np.array([row[0] for row in samples[:60]])
    assert any(
        np.allclose(printed[at : at + 60], found, rtol=0, atol=6e-9) for at in range(len(displacement))
    )


class SoundCard(ModuleType):
    """What of `sounddevice` is used: it gives blocks of full scale, and says once that it lost some."""

    def __init__(self) -> None:
        super().__init__("sounddevice")
        self.stopped = False

    def check_input_settings(self, *, device, channels, samplerate):
        if samplerate != 8000.0:
            raise ValueError("Invalid sample rate")

    def InputStream(self, *, callback, channels, **others):  # noqa: N802
        def start():
            for i in range(3):
                block = np.full((100, channels), 0.5, dtype=np.float32)
                callback(block, 100, None, SimpleNamespace(input_overflow=i == 1))

        return SimpleNamespace(start=start, stop=lambda: setattr(self, "stopped", True), close=lambda: None)


def test_a_sound_card_is_a_source_in_units_with_its_losses(monkeypatch):
    card = SoundCard()
    monkeypatch.setitem(sys.modules, "sounddevice", card)
    source = open_source("audio", LineOptions(units={"acceleration": "95 m/s^2"}))
    assert source.describe().rate_hz == 8000.0
    assert "AC coupled" in source.describe().remarks[0]
    source.start()
    readings = list(source.read())
    assert [reading.first for reading in readings] == [0, 101, 201]
    assert readings[0].samples[0, 0] == 47.5
    source.close()
    assert card.stopped


def test_a_sound_card_without_its_library_its_unit_or_its_rate(monkeypatch):
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(PortError, match=r"free-decay-station\[audio\]"):
        open_source("audio", LineOptions(units={"acceleration": "95 m/s^2"}))
    monkeypatch.setitem(sys.modules, "sounddevice", SoundCard())
    with pytest.raises(OperatorError, match="full scale"):
        open_source("audio:1", LineOptions())
    with pytest.raises(PortError, match="Invalid sample rate"):
        open_source("audio", LineOptions(units={"acceleration": "9 m/s^2"}, rate_hz=7.0)).describe()
