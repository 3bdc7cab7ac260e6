/* The board's side of the protocol: the state machine of docs/protocol.md, for any microcontroller.
 *
 * Its sizes stand in sizes.h; what it takes of code and RAM, in docs/firmware.md.
 */
#ifndef BOARD_H
#define BOARD_H

#include "sizes.h"
#include "wire.h"

#if BOARD_CHANNELS > WIRE_MAX_CHANNELS
#error "so many channels do not fit the frame of DESCRIBE"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Called once for each tick of the sampling timer, from an interrupt: one number of each channel, or NULL when
 * the sensors could not be read in time; and when the sample was taken, the lower 32 bits of hardware_ticks(). That is
 * read from the clock, never counted from the samples: it shows the station a pause that nobody counted. */
void board_sample(const int16_t *numbers, uint32_t ticks);

/* Called by the same interrupt, if it can tell: how many ticks of the board's clock after its instant it ran.
 * After each capture the board reports the spread of these as an EVENT. */
void board_late(uint16_t ticks);

#if BOARD_HOLDER
/* By a timer while hardware_holder_clock(true), from an interrupt. */
void board_holder_tick(void);

/* By a board that sees the host's end of its line: DTR of a USB port has dropped. */
void board_hung_up(void);
#endif

/* Once at boot, then step for ever. A step never waits. */
void board_begin(void);
void board_step(void);

#ifdef __cplusplus
}
#endif

#endif
