"""The reference firmware as images in emulators: an Arduino Mega in simavr, a Cortex-M3 in QEMU."""
