/* The board's side of the protocol: the state machine of docs/protocol.md, for any microcontroller.
 *
 * RAM: the ring (BOARD_RING samples of 2 bytes a channel: 16 KB for two channels at 256 Hz) and about 1.4 KB.
 */
#ifndef BOARD_H
#define BOARD_H

#define WIRE_RECEIVE_MAX 64 /* no request is longer; longer frames are somebody else's and are dropped */
#include "wire.h"

#define BOARD_CHANNELS 2
#define BOARD_RING 4096 /* samples that are kept, a power of two */
#define BOARD_KEEP_S 12 /* seconds that the protocol asks to keep: the rate is at most BOARD_RING / 12 s */

#if BOARD_CHANNELS > WIRE_MAX_CHANNELS
#error "so many channels do not fit the frame of DESCRIBE"
#endif

/* Called at each tick of the sampling timer, from its interrupt: one number of each channel, or NULL when
 * the sensors could not be read in time. */
void board_sample(const int16_t *numbers);

/* Once at boot, then step for ever. A step never waits. */
void board_begin(void);
void board_step(void);

#endif
