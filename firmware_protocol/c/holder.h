/* What holds the mass: an electromagnet on a carriage, driven by a stepper along the motion (drawn in docs/firmware.md).
 *
 * The carriage stands outside of the mass's swing. To hold, it goes to where the mass rests, grips, and pulls the mass
 * outward. To let go at once, it cuts the magnet's current and backs off by `clear_um`, since the mass comes nearly back.
 * To let go slowly, it takes the mass back to its place of rest, opens there, and leaves. Every step is one tick of a
 * timer that runs only meanwhile: the decay is recorded with nothing moving. After a boot nobody knows where the carriage
 * is: the first HOLD begins at the end switch.
 */
#ifndef HOLDER_H
#define HOLDER_H

#include "hardware.h"

enum holder_phase {
    HOLDER_FREE,
    HOLDER_SEEKS_END,
    HOLDER_APPROACHES,
    HOLDER_GRIPS,
    HOLDER_CARRIES,
    HOLDER_HOLDS,
    HOLDER_RETURNS,
    HOLDER_OPENS,
    HOLDER_LEAVES,
    HOLDER_STUCK
};

/* Steps count outward from where the magnet touches the mass at rest. */
struct holder {
    volatile uint8_t phase; /* enum holder_phase */
    bool knows_place;
    int32_t place, target; /* of the carriage */
    int32_t wanted;        /* where the mass is to be held */
    uint32_t left;         /* ticks: of waiting, or of patience for the end switch */
};

static inline int32_t holder_steps(int32_t um) { return um * hardware_holder.steps_per_mm / 1000; }

static inline uint32_t holder_grip_ticks(void) { return hardware_holder.ticks_hz / 4; }

/* Take the mass so far outward from its place of rest; one that is held is taken from where it is. */
static inline void holder_hold(struct holder *holder, int32_t um) {
    hardware_holder_clock(false);
    holder->wanted = holder_steps(um);
    if (holder->phase == HOLDER_HOLDS) {
        holder->target = holder->wanted;
        holder->phase = HOLDER_CARRIES;
    } else if (holder->knows_place) {
        holder->target = 0;
        holder->phase = HOLDER_APPROACHES;
    } else {
        holder->left = 2 * (uint32_t)holder_steps(hardware_holder.end_um);
        holder->phase = HOLDER_SEEKS_END;
    }
    hardware_holder_clock(true);
}

/* Let go at once. */
static inline void holder_release(struct holder *holder) {
    hardware_holder_magnet(false);
    hardware_holder_clock(false);
    holder->target = holder->place + holder_steps(hardware_holder.clear_um);
    holder->phase = HOLDER_LEAVES;
    hardware_holder_clock(true);
}

/* Take a mass that is held back to its place of rest and open there; else stand still. */
static inline void holder_let_go_slowly(struct holder *holder) {
    hardware_holder_clock(false);
    if (holder->phase == HOLDER_CARRIES || holder->phase == HOLDER_HOLDS) {
        holder->target = 0;
        holder->phase = HOLDER_RETURNS;
        hardware_holder_clock(true);
    } else if (holder->phase != HOLDER_RETURNS && holder->phase != HOLDER_OPENS && holder->phase != HOLDER_LEAVES) {
        hardware_holder_magnet(false);
        holder->phase = HOLDER_FREE;
    } else {
        hardware_holder_clock(true);
    }
}

/* One step toward the target; true when it is there. */
static inline bool holder_steps_on(struct holder *holder) {
    bool outward = holder->target > holder->place;
    if (holder->target == holder->place) return true;
    if (outward && hardware_holder_at_end()) {
        holder->place = holder->target = holder_steps(hardware_holder.end_um);
        return true;
    }
    hardware_holder_step(outward);
    holder->place += outward ? 1 : -1;
    return false;
}

static inline void holder_waits(struct holder *holder, uint8_t phase) {
    holder->left = holder_grip_ticks();
    holder->phase = phase;
}

static inline void holder_goes(struct holder *holder, uint8_t phase, int32_t target) {
    holder->target = target;
    holder->phase = phase;
}

/* From the timer's interrupt. */
static inline void holder_tick(struct holder *holder) {
    switch (holder->phase) {
    case HOLDER_SEEKS_END:
        if (hardware_holder_at_end()) {
            holder->place = holder_steps(hardware_holder.end_um);
            holder->knows_place = true;
            holder_goes(holder, HOLDER_APPROACHES, 0);
        } else if (holder->left-- == 0) {
            holder->phase = HOLDER_STUCK;
        } else {
            hardware_holder_step(true);
        }
        break;
    case HOLDER_APPROACHES:
        if (!holder_steps_on(holder)) break;
        hardware_holder_magnet(true);
        holder_waits(holder, HOLDER_GRIPS);
        break;
    case HOLDER_GRIPS:
        if (holder->left-- == 0) holder_goes(holder, HOLDER_CARRIES, holder->wanted);
        break;
    case HOLDER_CARRIES:
        if (holder_steps_on(holder)) holder->phase = HOLDER_HOLDS;
        break;
    case HOLDER_RETURNS:
        if (!holder_steps_on(holder)) break;
        hardware_holder_magnet(false);
        holder_waits(holder, HOLDER_OPENS);
        break;
    case HOLDER_OPENS:
        if (holder->left-- == 0) holder_goes(holder, HOLDER_LEAVES, holder_steps(hardware_holder.end_um));
        break;
    case HOLDER_LEAVES:
        if (holder_steps_on(holder)) holder->phase = HOLDER_FREE;
        break;
    default:
        break;
    }
    if (holder->phase == HOLDER_FREE || holder->phase == HOLDER_HOLDS || holder->phase == HOLDER_STUCK)
        hardware_holder_clock(false);
}

#endif
