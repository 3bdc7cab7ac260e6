/* Every size of the board's side in one place: samples kept, bytes of a frame, seconds of memory.
 *
 * Each may be given to the compiler instead (-DBOARD_RING=512). RAM used is about
 * BOARD_RING * (2 * BOARD_CHANNELS + 1/8 + 1/16) + BOARD_FRAME + 0.3 KB, and on the stack
 * BOARD_MOST_PER_FRAME * 2 * BOARD_CHANNELS + 0.3 KB.
 */
#ifndef SIZES_H
#define SIZES_H

#ifndef BOARD_CHANNELS
#define BOARD_CHANNELS 2
#endif

/* 1: the board has a holder (holder.h), which takes the mass to a displacement and lets it go. */
#ifndef BOARD_HOLDER
#define BOARD_HOLDER 0
#endif

/* BOARD_RING: samples that are kept for RESEND, a multiple of 8. BOARD_FRAME: bytes of the longest frame that
 * the board sends, before stuffing: DESCRIBE must fit. BOARD_KEEP_MS: a rate at which the ring would hold less
 * than this is refused. The protocol asks for 12 s; a board without the memory says here what it can do. */
#if !defined(BOARD_RING) && defined(__AVR_ATmega328P__) /* 2 KB of RAM */
#define BOARD_RING 48
#define BOARD_FRAME 240
#define BOARD_KEEP_MS 180
#define BOARD_MOST_PER_FRAME 16
#elif !defined(BOARD_RING) && defined(__AVR__) /* ATmega2560: 8 KB of RAM */
#if BOARD_HOLDER
#define BOARD_RING 1344
#else
#define BOARD_RING 1408
#endif
#define BOARD_FRAME 320
#define BOARD_KEEP_MS 700
#define BOARD_MOST_PER_FRAME 32
#elif !defined(BOARD_RING) && (defined(__ARM_ARCH_7M__) || defined(__ARM_ARCH_7EM__)) /* Cortex-M3, M4: 32 KB */
#define BOARD_RING 6144
#define BOARD_KEEP_MS 2900
#elif !defined(BOARD_RING)
#define BOARD_RING 4096
#endif

#ifndef BOARD_FRAME
#define BOARD_FRAME 1024
#endif
#ifndef BOARD_KEEP_MS
#define BOARD_KEEP_MS 12000
#endif

/* Samples in one frame: at most, and at least where CONFIG asks for no number. */
#ifndef BOARD_MOST_PER_FRAME
#define BOARD_MOST_PER_FRAME ((BOARD_FRAME - 12 - 24) / (2 * BOARD_CHANNELS))
#endif
#define BOARD_SAMPLES_PER_FRAME 16
#define WIRE_MAX_FRAME BOARD_FRAME
#define WIRE_RECEIVE_MAX 64 /* no request is longer; longer frames are somebody else's and are dropped */

#endif
