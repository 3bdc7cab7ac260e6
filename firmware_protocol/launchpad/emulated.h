/* What the emulator does not have: a converter with something at its pins, and chance.
 *
 * Compiled in with -DEMULATED only. The readings of each trigger come from the file `converter.bin` in the emulator's
 * folder, eight numbers of 16 bits a trigger, read through Arm semihosting. QEMU 7.2's converter interrupts at each
 * trigger of the timer, as it should, but its FIFO never says that it is empty: triggers are counted by the clock
 * instead, and none is lost when the computer was busy. Everything else is the board's own.
 */
#ifndef EMULATED_H
#define EMULATED_H

#include <stdbool.h>
#include <stdint.h>

#include "sizes.h"

#define TICKS_ADDED_BY_RELOADING 0 /* QEMU's timer takes one tick less than the chip's from one end to the next */

static inline int32_t semihosting(uint32_t operation, const void *arguments) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return (int32_t)r0;
}

static int32_t readings_file = -1;

/* Back to the first trigger; false without a file. */
static inline bool emulated_converter_begin(void) {
    static const char name[] = "converter.bin";
    const uint32_t open[3] = {(uint32_t)(uintptr_t)name, 1 /* rb */, sizeof name - 1};
    uint32_t seek[2];
    if (readings_file < 0) readings_file = semihosting(0x01, open);
    seek[0] = (uint32_t)readings_file;
    seek[1] = 0;
    return readings_file >= 0 && semihosting(0x0A, seek) == 0;
}

#if BOARD_HOLDER
/* A carriage 3 mm from its end switch, steps of 10 um. The mass rests at 0, or is where the magnet is, or swings: then
 * the file, which begins with REST_TRIGGERS of a mass that is held, is read from there on. */
#define REST_TRIGGERS 1024u
#define COUNTS_PER_STEP(n) ((n) * 4096 / 5000) /* 50 mm across the converter */

static volatile int32_t emulated_carriage = 2700;
static volatile bool emulated_is_held, emulated_swings;

static inline void emulated_step(bool outward) { emulated_carriage += outward ? 1 : -1; }
static inline bool emulated_at_end(void) { return emulated_carriage >= 3000; }

static inline void emulated_magnet(bool on) {
    if (emulated_is_held && !on) emulated_swings = emulated_carriage > 100;
    if (on) emulated_swings = false;
    emulated_is_held = on;
}
#endif

/* The readings of the next trigger; false behind the end of the file. */
static inline bool emulated_converter_read(uint16_t readings[8]) {
    const uint32_t read[3] = {(uint32_t)readings_file, (uint32_t)(uintptr_t)readings, 16};
#if BOARD_HOLDER
    static bool swung;
    if (!emulated_swings) {
        int32_t x = 2048 + (emulated_is_held ? COUNTS_PER_STEP(emulated_carriage) : 0);
        int i;
        for (i = 0; i < 8; i++) readings[i] = i == 0 || i == 3 || i == 4 || i == 7 ? (uint16_t)x : 2048;
        swung = false;
        return true;
    }
    if (!swung) {
        const uint32_t seek[2] = {(uint32_t)readings_file, 16 * REST_TRIGGERS};
        semihosting(0x0A, seek);
        swung = true;
    }
#endif
    return semihosting(0x06, read) == 0;
}

static inline uint32_t emulated_chance(void) {
    return (uint32_t)semihosting(0x10, 0) * 2654435761u ^ (uint32_t)semihosting(0x11, 0);
}

#endif
