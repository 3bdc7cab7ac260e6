/* The newest samples, written by the timer's interrupt and read by the main loop: unsent ones and ones that
 * the host may ask for again stand in the same ring. */
#ifndef RING_H
#define RING_H

#include "board.h"

#define RING_SAMPLE_BYTES (2 * BOARD_CHANNELS)

/* The clock is kept for each block of samples: 4 bytes for 64 of them, or for fewer where so few are kept. */
#define RING_BLOCK (BOARD_RING % 64 == 0 ? 64u : BOARD_RING % 16 == 0 ? 16u : 8u)
#define RING_TIMES (BOARD_RING / RING_BLOCK + 1)

typedef char ring_is_a_multiple_of_8[BOARD_RING % 8 == 0 ? 1 : -1];

struct ring {
    volatile uint32_t taken; /* index after the newest sample */
    volatile uint32_t limit; /* take no sample from this index on */
    volatile uint16_t slot;  /* where the next one goes: taken % BOARD_RING, without a division */
    volatile int16_t numbers[BOARD_RING][BOARD_CHANNELS];
    volatile uint8_t missing[BOARD_RING / 8]; /* one bit: the sensors could not be read */
    volatile uint8_t block;                   /* where the clock of the newest block is: taken / RING_BLOCK % RING_TIMES */
    volatile uint32_t times[RING_TIMES];      /* when the first sample of each block was taken */
};

/* A piece of the capture without a hole, and how many samples in front of it are not held. */
struct ring_run {
    uint32_t first;
    uint16_t n;
    uint32_t overrun; /* overwritten before they were read */
    uint32_t unread;  /* never came from the sensors */
};

/* Only while nothing samples. */
static inline void ring_clear(struct ring *ring, uint32_t limit) {
    ring->taken = 0;
    ring->slot = 0;
    ring->block = RING_TIMES - 1;
    ring->limit = limit;
}

static inline uint16_t ring_next_slot(uint16_t slot) { return slot + 1u < BOARD_RING ? (uint16_t)(slot + 1u) : 0; }

/* From the interrupt; `ticks` is when the sample was taken. */
static inline void ring_put(struct ring *ring, const int16_t *numbers, uint32_t ticks) {
    uint32_t at = ring->taken;
    uint16_t slot = ring->slot;
    uint8_t bit = (uint8_t)(1u << (slot % 8));
    if (at >= ring->limit) return;
    if (at % RING_BLOCK == 0) {
        ring->block = ring->block + 1u < RING_TIMES ? (uint8_t)(ring->block + 1u) : 0;
        ring->times[ring->block] = ticks;
    }
    if (numbers) {
        int channel;
        for (channel = 0; channel < BOARD_CHANNELS; channel++) ring->numbers[slot][channel] = numbers[channel];
        ring->missing[slot / 8] = (uint8_t)(ring->missing[slot / 8] & ~bit);
    } else {
        ring->missing[slot / 8] = (uint8_t)(ring->missing[slot / 8] | bit);
    }
    ring->slot = ring_next_slot(slot);
    ring->taken = at + 1;
}

/* From the main loop. A machine of 8 bits reads 32 bits in four steps, and the interrupt may come in between: it
 * comes once in two readings at most, so two that agree are right. */
static inline uint32_t ring_taken(const struct ring *ring) {
    uint32_t once, twice = ring->taken;
    do {
        once = twice;
        twice = ring->taken;
    } while (once != twice);
    return once;
}

/* When a sample that is held was taken, by the clock of its block and `period` ticks a sample from there. */
static inline uint32_t ring_time(const struct ring *ring, uint32_t index, uint32_t period) {
    return ring->times[index / RING_BLOCK % RING_TIMES] + index % RING_BLOCK * period;
}

static inline bool ring_is_missing(const struct ring *ring, uint16_t slot) {
    return ring->missing[slot / 8] >> (slot % 8) & 1;
}

static inline uint32_t ring_oldest(const struct ring *ring) {
    uint32_t taken = ring_taken(ring);
    return taken > BOARD_RING ? taken - BOARD_RING : 0;
}

/* Copy the first run in [from, end) as little-endian bytes, at most `most` samples; n is 0 when none is held. */
static inline struct ring_run ring_copy(const struct ring *ring, uint32_t from, uint32_t end, uint16_t most,
                                        uint8_t *bytes) {
    struct ring_run run;
    do {
        uint32_t oldest = ring_oldest(ring), start = from < oldest ? (oldest < end ? oldest : end) : from;
        uint16_t slot = (uint16_t)(start % BOARD_RING);
        uint8_t *out = bytes;
        int channel;
        run.overrun = start - from;
        run.first = start;
        run.n = 0;
        for (; run.first < end && ring_is_missing(ring, slot); slot = ring_next_slot(slot)) run.first++;
        run.unread = run.first - start;
        for (; run.n < most && run.first + run.n < end && !ring_is_missing(ring, slot); slot = ring_next_slot(slot)) {
            const volatile int16_t *numbers = ring->numbers[slot];
            for (channel = 0; channel < BOARD_CHANNELS; channel++) {
                uint16_t number = (uint16_t)numbers[channel];
                *out++ = (uint8_t)number;
                *out++ = (uint8_t)(number >> 8);
            }
            run.n++;
        }
        /* The interrupt may have overwritten the oldest of these meanwhile: then copy again. */
    } while (run.n > 0 && run.first < ring_oldest(ring));
    return run;
}

#endif
