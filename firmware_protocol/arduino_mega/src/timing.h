/* How evenly the samples of a capture were taken, measured by the board itself and said in one sentence.
 *
 * Each tick of the sampling timer has its instant; the interrupt notes how much later it really ran. What is the
 * same for all samples only shifts the clock; the difference between the latest and the earliest is jitter.
 */
#ifndef TIMING_H
#define TIMING_H

#include <stdbool.h>
#include <stdint.h>

#define TIMING_TEXT 80

/* Ticks of the board's clock. */
struct timing {
    volatile uint16_t earliest, latest;
};

static inline void timing_clear(struct timing *timing) {
    timing->earliest = 0xFFFFu;
    timing->latest = 0;
}

static inline void timing_note(struct timing *timing, uint16_t late) {
    if (late < timing->earliest) timing->earliest = late;
    if (late > timing->latest) timing->latest = late;
}

static inline bool timing_was_noted(const struct timing *timing) { return timing->earliest <= timing->latest; }

static inline char *timing_words(char *out, const char *words) {
    while (*words) *out++ = *words++;
    return out;
}

static inline char *timing_number(char *out, uint32_t number) {
    char digits[10];
    int count = 0;
    do digits[count++] = (char)('0' + (char)(number % 10));
    while (number /= 10);
    while (count) *out++ = digits[--count];
    return out;
}

/* Ticks as microseconds with one decimal. */
static inline char *timing_microseconds(char *out, uint16_t ticks, uint32_t clock_hz) {
    uint32_t tenths = (uint32_t)(((uint64_t)ticks * 10000000u + clock_hz / 2) / clock_hz);
    out = timing_number(out, tenths / 10);
    *out++ = '.';
    return timing_number(out, tenths % 10);
}

/* "sampled 0.8 to 9.1 us late, jitter 8.3 us; 0 of 2560 missed" into TIMING_TEXT bytes; returns the length. */
static inline uint8_t timing_text(char *text, const struct timing *timing, uint32_t clock_hz, uint32_t missed,
                                  uint32_t of) {
    char *out = timing_words(text, "sampled ");
    out = timing_microseconds(out, timing->earliest, clock_hz);
    out = timing_words(out, " to ");
    out = timing_microseconds(out, timing->latest, clock_hz);
    out = timing_words(out, " us late, jitter ");
    out = timing_microseconds(out, (uint16_t)(timing->latest - timing->earliest), clock_hz);
    out = timing_words(out, " us; ");
    out = timing_number(out, missed);
    out = timing_words(out, " of ");
    out = timing_number(out, of);
    out = timing_words(out, " missed");
    return (uint8_t)(out - text);
}

#endif
