/* The Free-Decay Station's board on an Arduino Mega 2560, to be flashed as it is.
 *
 * Settings of your rig (sensors, calibration, channels): rig.h. What the board does: hardware_mega.c.
 * `src` holds copies of firmware_protocol/c; change them there. The page: docs/board.md.
 */
#include "src/hardware.h"

void setup() {
    TIMSK0 = 0; /* the Arduino clock's interrupt would delay the samples; nothing here uses it */
    hardware_begin(0, 0);
    board_begin();
}

void loop() {
    board_step();
    hardware_wait();
}
