"""What the Mega's image makes of the sensors at its pins and buses, and how its clock is measured."""

from pathlib import Path

import numpy as np
import pytest
from conftest import or_skip

from bench import clock
from bench.emulated import boards, images, motion
from daq.errors import BoardError
from daq.link import Link
from daq.port import open_port

REST_S, MOTION_S, RATE_HZ = 0.5, 1.5, 256.0
# The analog one is read in turns with the displacement, over 3.33 ms after the tick; the digital ones at
# the tick, but that simavr takes 0.1 ms for a byte of SPI.
READ_AFTER_S = {"ADXL335": 32 * 13 * 128 / 16e6 / 2, "ADXL355": 1e-4, "MPU6050": 0.0}


@pytest.mark.slow
@pytest.mark.parametrize("sensor", READ_AFTER_S)
def test_each_accelerometer_is_read_in_si_units(tmp_path: Path, sensor: str) -> None:
    image = or_skip(images.mega, tmp_path / "mega.elf", "atmega2560", f"-DACCELERATION={sensor}")
    or_skip(images.simavr_board, tmp_path / "simavr_board")
    motion.write_volts(tmp_path / "volts.f32", rest_s=REST_S, motion_s=MOTION_S)
    with (
        boards.mega(tmp_path, image, options=("--sensor", sensor)) as board,
        Link(open_port(board.port)) as link,
    ):
        link.handshake()
        link.configure(RATE_HZ)
        link.start()
        link.wait(lambda message: False, REST_S + 1.0)
        link.stop()
        recording = link.assembly.recording()
    assert not recording.gaps
    time_s = np.arange(recording.samples.shape[1]) / RATE_HZ
    at_pins = motion.volts(rest_s=REST_S, motion_s=MOTION_S)
    seen = np.interp(time_s + READ_AFTER_S[sensor], np.arange(len(at_pins)) / motion.FILE_HZ, at_pins[:, 1])
    acceleration = (seen - motion.SUPPLY_V / 2) / motion.V_PER_M_S2
    step = (time_s > REST_S - 0.01) & (time_s < REST_S + 0.02)  # let go: 4000 m/s^3 behind the RC
    error = (recording.samples[1] - acceleration)[~step]
    # 2 mV a reading and 16 readings: 0.015 m/s^2; 20 us of the tick's interrupt are worth 0.006 m/s^2 where the jerk is
    # greatest; the mean over 3 ms of a cosine of 4 Hz is 0.1 % less, 0.01 m/s^2.
    assert np.sqrt(np.mean(error**2)) < 0.025
    assert abs(np.mean(error)) < 0.005


@pytest.mark.slow
def test_a_digital_sensor_that_is_not_there_refuses_the_capture(tmp_path: Path) -> None:
    image = or_skip(images.mega, tmp_path / "mega.elf", "atmega2560", "-DACCELERATION=MPU6050")
    or_skip(images.simavr_board, tmp_path / "simavr_board")
    with boards.mega(tmp_path, image) as board, Link(open_port(board.port)) as link:
        link.handshake()
        with pytest.raises(BoardError, match="a sensor does not answer"):
            link.start()


@pytest.mark.slow
def test_the_board_s_clock_is_measured(
    mega_image: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    or_skip(images.simavr_board, tmp_path / "simavr_board")
    found = []
    with boards.mega(tmp_path, mega_image) as board:
        while len(found) < 5 and max(found, default=0) < 0.9 * 16e6:
            clock.main(board.port, 2.0)
            found.append(int(capsys.readouterr().out))
    # An emulator on a busy machine lags, which reads as a slow clock; a wrong formula is off by more each time.
    assert max(found) == pytest.approx(16e6, rel=0.1)
