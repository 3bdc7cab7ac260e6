/* The rules of the holder, which the board alone keeps: limits, fresh commands, silence, STOP (docs/protocol.md,
 * "Holding and letting go"). Nothing here moves but by an accepted HOLD or RELEASE, or slowly back to rest. A part of
 * board.c, and nothing of it without BOARD_HOLDER. */
#ifndef HOLDING_H
#define HOLDING_H

#include "hardware.h"

#if BOARD_HOLDER
#include "holder.h"

#ifndef HOLDING_SILENCE_S
#define HOLDING_SILENCE_S 2
#endif
#define HOLDING_SILENCE (HOLDING_SILENCE_S * (uint64_t)hardware_clock_hz)
#define HOLDING_REPORT (hardware_clock_hz / 4)

static struct holding {
    struct holder holder;
    uint8_t state, reason; /* enum wire_holder_state, wire_holder_reason */
    uint32_t ticket;
    int32_t um; /* where the mass is held or moved to */
    uint64_t released; /* sample */
    uint8_t done;      /* type of the last request carried out while what it asked for still holds, or 0 */
    uint32_t done_ticket;
    uint32_t heard_sequence;
    uint64_t heard, said;
    bool has_news;
    volatile bool hung_up;
} holding;

static inline void holding_renew(void) { holding.ticket = holding.ticket * 1664525u + 1013904223u; }

static inline void holding_become(uint8_t state, uint8_t reason) {
    holding.state = state;
    holding.reason = reason;
    holding.has_news = true;
    holding.done = 0;
    holding_renew();
}

static inline void holding_begin(uint32_t boot_id) {
    holding.state = WIRE_FREE;
    holding.reason = WIRE_BY_BOOT;
    holding.released = WIRE_NO_SAMPLE;
    holding.ticket = boot_id;
    holding_renew();
}

/* Whatever is a request, and neither an echo nor the frame before once more, is a sign of a host. */
static inline void holding_hear(const struct wire_frame *frame, uint64_t now) {
    bool echo = frame->message.type == WIRE_TIMESYNC && frame->message.as.timesync.board_time_us != 0;
    if (frame->message.type >= 0x80 || echo || frame->sequence == holding.heard_sequence) return;
    holding.heard = now;
    holding.heard_sequence = frame->sequence;
}

static inline void holding_let_go_slowly(uint8_t reason) {
    if (holding.state != WIRE_MOVING && holding.state != WIRE_HELD) return;
    holder_let_go_slowly(&holding.holder);
    holding.um = 0;
    holding_become(WIRE_LETTING_GO, reason);
}

/* Whole micrometres; false when it is outside the limits or no number. */
static inline bool holding_allows(wire_real displacement, int32_t *um) {
    if (!(displacement > -1 && displacement < 1)) return false;
    *um = (int32_t)(displacement * 1000000 + (displacement < 0 ? (wire_real)-0.5 : (wire_real)0.5));
    return *um >= hardware_holder.low_um && *um <= hardware_holder.high_um;
}

/* Why a HOLD or RELEASE is refused, as a NACK code and words; 0: it is not. */
static inline uint8_t holding_refusal(const struct wire_message *m, int32_t *um,
                                      const char **why) {
    bool hold = m->type == WIRE_HOLD;
    *why = "nothing is held";
    if (!hold && holding.state != WIRE_HELD) return WIRE_NOTHING_HELD;
    *why = "not a fresh command: its ticket is not the newest";
    if ((hold ? m->as.hold.ticket : m->as.release.ticket) != holding.ticket) return WIRE_STALE;
    if (!hold) return 0;
    *why = "the holder moves";
    if (holding.state == WIRE_MOVING || holding.state == WIRE_LETTING_GO) return WIRE_BUSY;
    *why = "the stop contact is open";
    if (hardware_stop_contact_is_open()) return WIRE_NACK_HOLDER;
    *why = "the displacement is outside this rig's limits";
    return holding_allows(m->as.hold.displacement, um) ? 0 : WIRE_LIMIT;
}

/* A capture begins: no sample of it was released. */
static inline void holding_started(void) { holding.released = WIRE_NO_SAMPLE; }

/* DESCRIBE was sent: HOLDER follows. */
static inline void holding_say(void) { holding.has_news = true; }

/* Carry out a HOLD or RELEASE; `next_sample` says which one is taken next. Returns as holding_refusal(). */
static inline uint8_t holding_obey(const struct wire_message *m, uint64_t (*next_sample)(void),
                                   const char **why) {
    bool hold = m->type == WIRE_HOLD;
    uint32_t ticket = hold ? m->as.hold.ticket : m->as.release.ticket;
    int32_t um = 0;
    uint8_t code;
    if (holding.done == m->type && holding.done_ticket == ticket &&
        (!hold || (holding_allows(m->as.hold.displacement, &um) && um == holding.um))) {
        holding.has_news = true; /* its ACK was lost */
        return 0;
    }
    code = holding_refusal(m, &um, why);
    if (code) return code;
    if (hold) {
        holder_hold(&holding.holder, um * hardware_holder.side);
        holding.um = um;
    } else {
        holder_release(&holding.holder);
        holding.um = 0;
        holding.released = next_sample();
    }
    holding_become(hold ? WIRE_MOVING : WIRE_FREE, WIRE_BY_REQUEST);
    holding.done = m->type;
    holding.done_ticket = ticket;
    return 0;
}

/* At each step of the main loop: silence, stop contact, what the carriage has reached. */
static inline void holding_watch(uint64_t now) {
    uint8_t phase = holding.holder.phase;
    if (now - holding.heard >= HOLDING_SILENCE) {
        holding.heard = now;
        holding_renew();
        holding_let_go_slowly(WIRE_BY_SILENCE);
    }
    if (holding.hung_up) holding_let_go_slowly(WIRE_BY_SILENCE);
    holding.hung_up = false;
    if (hardware_stop_contact_is_open()) holding_let_go_slowly(WIRE_BY_CONTACT);
    if (holding.state == WIRE_MOVING && phase == HOLDER_HOLDS) {
        holding.state = WIRE_HELD;
        holding.has_news = true;
    } else if (holding.state == WIRE_MOVING && phase == HOLDER_STUCK) {
        holding.um = 0;
        holding_become(WIRE_FREE, WIRE_BY_FAULT);
    } else if (holding.state == WIRE_LETTING_GO && phase == HOLDER_FREE) {
        holding.state = WIRE_FREE;
        holding.has_news = true;
    }
}

static inline bool holding_report_is_due(uint64_t now) {
    return holding.has_news || (holding.state != WIRE_FREE && now - holding.said >= HOLDING_REPORT);
}

static inline void holding_report(struct wire_message *m, uint64_t now) {
    struct wire_holder *report = &m->as.holder;
    m->type = WIRE_HOLDER;
    report->low = hardware_holder.low_um * (wire_real)1e-6;
    report->high = hardware_holder.high_um * (wire_real)1e-6;
    report->silence_s = HOLDING_SILENCE_S;
    report->ticket = holding.ticket;
    report->state = holding.state;
    report->reason = holding.reason;
    report->displacement = holding.um * (wire_real)1e-6;
    report->sample = holding.released;
    holding.has_news = false;
    holding.said = now;
}

void board_holder_tick(void) { holder_tick(&holding.holder); }
void board_hung_up(void) { holding.hung_up = true; }

#else /* no holder: HOLD and RELEASE are not understood */
#define holding_begin(boot_id) ((void)0)
#define holding_started() ((void)0)
#define holding_hear(frame, now) ((void)0)
#define holding_let_go_slowly(reason) ((void)0)
#define holding_obey(m, next_sample, why) ((void)(next_sample), *(why) = "", WIRE_NOT_UNDERSTOOD)
#define holding_watch(now) ((void)0)
#define holding_say() ((void)0)
#define holding_report_is_due(now) false
#define holding_report(m, now) ((void)0)
#endif

#endif
