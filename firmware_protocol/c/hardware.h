/* What the owner of a board fills in: eleven small functions and the description of the channels.
 *
 * `board.c` calls these and nothing else of the board. `hardware_host.c` fills them in for a computer.
 */
#ifndef HARDWARE_H
#define HARDWARE_H

#include "board.h"

extern const char hardware_firmware[]; /* name and version of the firmware */
extern const char hardware_board[];    /* model of the board */
extern const uint32_t hardware_clock_hz; /* nominal frequency of the clock that times the samples */

extern const double hardware_clock_error_ppm; /* by how much it may be off, by its data sheet; 0: not known */

/* The channels in the order of the numbers given to board_sample(); rate_hz is filled in by board.c. */
extern const struct wire_channel hardware_channels[BOARD_CHANNELS];

/* Clocks, port and converter; sampling is off. */
void hardware_begin(int count, char **arguments);

/* Sleep until an interrupt: a byte came, a byte went, a sample was taken, 10 ms passed. May return at once. */
void hardware_wait(void);

/* Microseconds since boot, from the clock that times the samples. 64 bits: 32 would be over in 71 minutes. */
uint64_t hardware_time_us(void);

/* Another number at each boot. */
uint32_t hardware_boot_id(void);
uint8_t hardware_reset_cause(void); /* enum wire_reset_cause */
const char *hardware_unique_id(void);

/* Take received bytes, or give bytes to send: never wait, return how many. */
size_t hardware_receive(uint8_t *bytes, size_t room);
size_t hardware_send(const uint8_t *bytes, size_t count);

/* The rate nearest to the one asked for (0: the preferred one) that the timer can make, 0 when none is near. */
double hardware_rate(double asked_hz);

/* From now on call board_sample() at each tick of the timer; sample 0 is taken at *first_us.
 * False when a sensor does not answer. */
bool hardware_start_sampling(double rate_hz, uint64_t *first_us);

/* No call of board_sample() after this has returned. */
void hardware_stop_sampling(void);

#endif
