"""The board's side compiles for small processors without a warning, and takes what the page says."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from bench.emulated import boards, images
from bench.emulated.images import ARM_INCLUDES, CORE, MEGA, ROOT, STRICT, ToolMissing
from daq.link import Link
from daq.port import open_port

FIRMWARE_PAGE = ROOT / "docs" / "firmware.md"
ROW = re.compile(r"^\| (.+?) \| ([\d.]+) KB \| ([\d.]+) KB \| (\d+) \|$", re.M)
ARDUINO_CORE = Path("/usr/share/arduino/hardware/arduino/avr")


def built(build: Callable[..., Path], *arguments: object) -> Path:
    try:
        return build(*arguments)
    except ToolMissing as missing:
        pytest.skip(str(missing))


def test_the_sketch_holds_copies_of_the_board_s_side() -> None:
    for copy in sorted((MEGA / "src").iterdir()):
        original = CORE / copy.name
        assert copy.read_bytes() == original.read_bytes(), f"cp {original} {copy}"


def test_the_sketch_includes_nothing_from_outside_its_folder() -> None:
    for source in MEGA.rglob("*.[chi]*"):
        for name in re.findall(r'#include "(.*)"', source.read_text("utf-8")):
            assert (source.parent / name).resolve().is_relative_to(MEGA), (source, name)
            assert (source.parent / name).exists(), (source, name)


@pytest.mark.slow
@pytest.mark.parametrize("sensor", ["ADXL355", "MPU6050"])  # ADXL335: the sizes below
def test_both_boards_compile_with_every_sensor(tmp_path: Path, sensor: str) -> None:
    given = f"-DACCELERATION={sensor}"
    targets: tuple[tuple[Callable[..., Path], tuple[str, ...]], ...] = (
        (images.mega, ("atmega328p",)),  # the one with the least memory
        (images.launchpad, ()),
        (images.launchpad, ("-DBOARD_LM3S6965",)),
    )
    for i, (build, flags) in enumerate(targets):
        assert built(build, tmp_path / f"{i}.elf", *flags, given).read_bytes().startswith(b"\x7fELF")


@pytest.mark.slow
@pytest.mark.parametrize("real", [(), ("-DWIRE_REAL=float",)])
def test_the_board_s_side_compiles_for_cortex_m0plus(tmp_path: Path, real: tuple[str, ...]) -> None:
    """For Cortex-M3 and M4F it is compiled with the images whose sizes are measured."""
    command = ["arm-none-eabi-gcc", "-mcpu=cortex-m0plus", "-mthumb", *STRICT, "-Os", "-ffreestanding", *real]
    try:
        images.need(command[0])
    except ToolMissing as missing:
        pytest.skip(str(missing))
    subprocess.run([*command, *ARM_INCLUDES, "-c", CORE / "board.c", "-o", tmp_path / "board.o"], check=True)


HOLDER = "-DBOARD_HOLDER=1"

# What is measured for each row of the page's table: the image, and the tool that weighs it.
IMAGES: dict[str, tuple[Callable[..., Path], tuple[str, ...], str]] = {
    "Arduino Mega (ATmega2560)": (images.mega, ("atmega2560",), "avr-size"),
    "Arduino Mega with a holder": (images.mega, ("atmega2560", HOLDER), "avr-size"),
    "Arduino Uno, Nano (ATmega328P)": (images.mega, ("atmega328p",), "avr-size"),
    "EK-TM4C123GXL (Cortex-M4F)": (images.launchpad, (), "arm-none-eabi-size"),
    "EK-TM4C123GXL with a holder": (images.launchpad, (HOLDER,), "arm-none-eabi-size"),
    "LM3S6965 in QEMU (Cortex-M3)": (images.launchpad, images.EMULATED, "arm-none-eabi-size"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", IMAGES)
def test_code_and_ram_are_what_the_page_says(tmp_path: Path, name: str) -> None:
    rows = {row[0]: row[1:] for row in ROW.findall(FIRMWARE_PAGE.read_text("utf-8"))}
    assert set(rows) == set(IMAGES)
    build, flags, tool = IMAGES[name]
    size = images.size(built(build, tmp_path / "image.elf", *flags), tool)
    flash, ram, samples = rows[name]
    # Another version of the compiler may differ by some per cent.
    assert size.flash / 1000 == pytest.approx(float(flash), rel=0.05)
    assert size.ram / 1000 == pytest.approx(float(ram), rel=0.02)
    assert int(samples) == ring(tool, flags)


def ring(tool: str, flags: tuple[str, ...]) -> int:
    """Samples kept, as the preprocessor of that board's compiler sees sizes.h."""
    target = [f"-mmcu={flags[0]}"] if tool == "avr-size" else ["-mcpu=cortex-m3", "-mthumb"]
    target += [flag for flag in flags if flag == HOLDER]
    compiler = tool.replace("size", "gcc")
    text = f'#include "{CORE / "sizes.h"}"\nBOARD_RING\n'
    done = subprocess.run(
        [compiler, *target, "-E", "-P", "-"], input=text, capture_output=True, text=True, check=True
    )
    return int(done.stdout.split()[-1])


@pytest.mark.slow
def test_the_sketch_compiles_with_the_arduino_s_own_core(tmp_path: Path) -> None:
    """As the Arduino IDE does it: the sketch as C++ behind Arduino.h, every .c below it, linked with the core."""
    if not ARDUINO_CORE.exists():
        pytest.skip("the Arduino core is not on this machine (Debian: arduino-core-avr)")
    core = ARDUINO_CORE / "cores" / "arduino"
    flags = [
        "-mmcu=atmega2560",
        "-Os",
        "-DF_CPU=16000000L",
        "-DARDUINO=10819",
        "-DARDUINO_AVR_MEGA2560",
        "-w",
    ]
    flags += [
        "-ffunction-sections",
        "-fdata-sections",
        "-flto",
        f"-I{core}",
        f"-I{ARDUINO_CORE / 'variants/mega'}",
    ]
    sketch = tmp_path / "sketch.cpp"
    sketch.write_text(f'#include <Arduino.h>\n#include "{MEGA / "arduino_mega.ino"}"\n')
    objects = []
    try:
        images.need("avr-gcc")
    except ToolMissing as missing:
        pytest.skip(str(missing))
    own = [sketch, *images.MEGA_SOURCES]
    for number, source in enumerate([*own, *sorted(core.glob("*.c")), core / "main.cpp"]):
        objects.append(tmp_path / f"{number}.o")
        language = ["-std=gnu++11", "-fpermissive"] if source.suffix == ".cpp" else ["-std=gnu11"]
        subprocess.run(
            ["avr-gcc", *flags, *language, f"-I{MEGA}", "-c", source, "-o", objects[-1]],
            check=True,
            timeout=60,
        )
    image = tmp_path / "sketch.elf"
    subprocess.run(
        ["avr-gcc", *flags, "-Wl,--gc-sections", *objects, "-o", image, "-lm"], check=True, timeout=60
    )
    assert images.size(image, "avr-size").ram < 7500
    built(images.simavr_board, tmp_path / "simavr_board")
    with boards.mega(tmp_path, image) as board, Link(open_port(board.port)) as link:
        assert link.handshake().board == "Arduino Mega 2560"
        link.start()
        link.wait(lambda message: link.assembly.samples.received > 64, 60.0)
        link.stop()
        assert link.assembly.recording().samples.shape[1] > 64
