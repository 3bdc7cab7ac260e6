/* What the owner of a board fills in: eleven small functions (five more for a holder) and the description of the channels.
 *
 * `board.c` calls these and nothing else of the board. `hardware_host.c` fills them in for a computer,
 * `arduino_mega/` and `launchpad/` for two boards.
 */
#ifndef HARDWARE_H
#define HARDWARE_H

#include "board.h"

#ifdef __cplusplus
extern "C" {
#endif

extern const char hardware_firmware[]; /* name and version of the firmware */
extern const char hardware_board[];    /* model of the board */

/* Frequency of the clock that times the samples, as well as it is known. All times below are its ticks. */
extern const uint32_t hardware_clock_hz;

extern const wire_real hardware_clock_error_ppm; /* by how much it may be off, by its data sheet; 0: not known */

/* The channels in the order of the numbers given to board_sample(); rate_hz is filled in by board.c. */
extern const struct wire_channel hardware_channels[BOARD_CHANNELS];

/* Clocks, port and converter; sampling is off. */
void hardware_begin(int count, char **arguments);

/* Sleep until an interrupt: a byte came, a byte went, a sample was taken, 10 ms passed. May return at once. */
void hardware_wait(void);

/* Ticks since boot. 64 bits: 32 would be over in 4 minutes of 16 MHz. */
uint64_t hardware_ticks(void);

/* Another number at each boot. */
uint32_t hardware_boot_id(void);
uint8_t hardware_reset_cause(void); /* enum wire_reset_cause */
const char *hardware_unique_id(void);

/* Take received bytes, or give bytes to send: never wait, return how many. */
size_t hardware_receive(uint8_t *bytes, size_t room);
size_t hardware_send(const uint8_t *bytes, size_t count);

/* Ticks from one sample to the next at the rate nearest to the one asked for (0: the preferred one) that the
 * timer can make; 0 when none is near. The rate is hardware_clock_hz / this, exactly. */
uint32_t hardware_period(wire_real asked_hz);

/* From now on call board_sample() at each tick of the timer; sample 0 is taken at *first, in ticks since boot.
 * False when a sensor does not answer. */
bool hardware_start_sampling(uint32_t period, uint64_t *first);

/* No call of board_sample() after this has returned. */
void hardware_stop_sampling(void);

#if BOARD_HOLDER
/* A magnet on a stepper, see holder.h. Lengths in um, outward from where the magnet touches the mass at rest. */
struct hardware_holder {
    int32_t low_um, high_um; /* displacements that may be held: both on the carriage's side of 0, or 0 */
    int8_t side;             /* outward is positive displacement: 1, negative: -1 */
    int32_t end_um;          /* where the end switch closes: beyond the farthest displacement and clear_um */
    int32_t clear_um;        /* how far the carriage backs off when it lets go */
    int32_t steps_per_mm, ticks_hz; /* a step a tick; together the speed, 5 mm/s at most */
};
extern const struct hardware_holder hardware_holder;

/* Call board_holder_tick() so often, or no more. After boot: no more. */
void hardware_holder_clock(bool runs);
void hardware_holder_step(bool outward);
void hardware_holder_magnet(bool on); /* after boot: off */
bool hardware_holder_at_end(void);
bool hardware_stop_contact_is_open(void); /* a button at the rig; a broken wire counts as open */
#endif

#ifdef __cplusplus
}
#endif

#endif
