"""The firmware's images: how each is built, from which sources, and how much it takes."""

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "firmware_protocol" / "c"
MEGA = ROOT / "firmware_protocol" / "arduino_mega"
LAUNCHPAD = ROOT / "firmware_protocol" / "launchpad"
SIMAVR_BOARD = Path(__file__).parent / "simavr_board.c"

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror")
SMALL = ("-Os", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections")
AVR = ("avr-gcc", *STRICT, *SMALL)
ARM = (
    "arm-none-eabi-gcc",
    "-mthumb",
    *STRICT,
    *SMALL,
    "-ffreestanding",
    "-fno-tree-loop-distribute-patterns",
)
ARM_INCLUDES = ("-isystem", str(LAUNCHPAD / "freestanding"), f"-I{CORE}", f"-I{LAUNCHPAD}")
EMULATED = ("-DBOARD_LM3S6965", "-DEMULATED")

MEGA_SOURCES = tuple(MEGA / name for name in ("hardware_mega.c", "bus_mega.c", "src/board.c"))
LAUNCHPAD_SOURCES = (
    *(LAUNCHPAD / name for name in ("startup.c", "hardware_launchpad.c", "bus_launchpad.c")),
    CORE / "board.c",
    CORE / "main.c",
)


class ToolMissing(Exception):
    """A compiler or an emulator that is not on this machine; its words say which, and its package."""


PACKAGES = {
    "avr-gcc": "gcc-avr and avr-libc",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi",
    "qemu-system-arm": "qemu-system-arm",
    "cc": "gcc",
}


def need(*tools: str) -> None:
    """Raise ToolMissing for the first that is not there."""
    for tool in tools:
        if shutil.which(tool) is None:
            raise ToolMissing(f"{tool} is not on this machine (Debian: {PACKAGES[tool]})")


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    if done.returncode:
        raise AssertionError(f"{' '.join(command)}\n{done.stderr}")
    return done.stdout


def mega(out: Path, mcu: str = "atmega2560", *flags: str) -> Path:
    """Build the Arduino's image without the Arduino's library, by Debian's avr-gcc and avr-libc."""
    need("avr-gcc")
    sources = (*MEGA_SOURCES, CORE / "main.c")
    _run([*AVR, f"-mmcu={mcu}", *flags, f"-I{MEGA / 'src'}", *map(str, sources), "-o", str(out)])
    return out


def launchpad(out: Path, *flags: str) -> Path:
    """Build the Cortex-M's image; with EMULATED the one for QEMU, else the one to be flashed."""
    need("arm-none-eabi-gcc")
    link = ("-nostdlib", "-T", str(LAUNCHPAD / "launchpad.ld"))
    _run(
        [
            *ARM,
            "-mcpu=cortex-m3",
            *flags,
            *ARM_INCLUDES,
            *map(str, LAUNCHPAD_SOURCES),
            *link,
            "-lgcc",
            "-o",
            str(out),
        ]
    )
    return out


def simavr_board(out: Path) -> Path:
    """Build the program that runs an AVR image in simavr."""
    need("cc")
    if not Path("/usr/include/simavr/sim_avr.h").exists():
        raise ToolMissing("simavr is not on this machine (Debian: libsimavr-dev and libelf-dev)")
    flags, libraries = ("-std=gnu11", "-O2", "-Wall", "-Wextra", "-Werror"), ("-lsimavr", "-lelf", "-lm")
    _run(["cc", *flags, str(SIMAVR_BOARD), "-o", str(out), *libraries])
    return out


@dataclass(frozen=True)
class Size:
    """Bytes of flash (code and constants) and of RAM (variables; the stack comes on top)."""

    flash: int
    ram: int


def size(image: Path, tool: str) -> Size:
    """Return what the image takes, by `avr-size` or `arm-none-eabi-size`."""
    text, data, bss = map(int, re.findall(r"\d+", _run([tool, str(image)]).splitlines()[1])[:3])
    return Size(text + data, data + bss)
