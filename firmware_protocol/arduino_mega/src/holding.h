/* The rules of the holder, which the board alone keeps: limits, fresh commands, silence, STOP (docs/protocol.md,
 * "Holding and letting go"). Nothing here moves but by an accepted HOLD or RELEASE, or slowly back to rest. */
#ifndef HOLDING_H
#define HOLDING_H

#include "holder.h"

#define HOLDING_SILENCE_S 2
#define HOLDING_SILENCE (HOLDING_SILENCE_S * (uint64_t)hardware_clock_hz)
#define HOLDING_REPORT (hardware_clock_hz / 4)

struct holding {
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
};

static inline void holding_renew(struct holding *h) { h->ticket = h->ticket * 1664525u + 1013904223u; }

static inline void holding_become(struct holding *h, uint8_t state, uint8_t reason) {
    h->state = state;
    h->reason = reason;
    h->has_news = true;
    h->done = 0;
    holding_renew(h);
}

static inline void holding_begin(struct holding *h, uint32_t boot_id) {
    h->state = WIRE_FREE;
    h->reason = WIRE_BY_BOOT;
    h->released = WIRE_NO_SAMPLE;
    h->ticket = boot_id;
    holding_renew(h);
}

/* Whatever is a request, and neither an echo nor the frame before once more, is a sign of a host. */
static inline void holding_hear(struct holding *h, const struct wire_frame *frame, uint64_t now) {
    bool echo = frame->message.type == WIRE_TIMESYNC && frame->message.as.timesync.board_time_us != 0;
    if (frame->message.type >= 0x80 || echo || frame->sequence == h->heard_sequence) return;
    h->heard = now;
    h->heard_sequence = frame->sequence;
}

static inline void holding_let_go_slowly(struct holding *h, uint8_t reason) {
    if (h->state != WIRE_MOVING && h->state != WIRE_HELD) return;
    holder_let_go_slowly(&h->holder);
    h->um = 0;
    holding_become(h, WIRE_LETTING_GO, reason);
}

/* Whole micrometres; false when it is outside the limits or no number. */
static inline bool holding_allows(wire_real displacement, int32_t *um) {
    if (!(displacement > -1 && displacement < 1)) return false;
    *um = (int32_t)(displacement * 1000000 + (displacement < 0 ? (wire_real)-0.5 : (wire_real)0.5));
    return *um >= hardware_holder.low_um && *um <= hardware_holder.high_um;
}

/* Why a HOLD or RELEASE is refused, as a NACK code and words; 0: it is not. */
static inline uint8_t holding_refusal(const struct holding *h, const struct wire_message *m, int32_t *um,
                                      const char **why) {
    bool hold = m->type == WIRE_HOLD;
    *why = "nothing is held";
    if (!hold && h->state != WIRE_HELD) return WIRE_NOTHING_HELD;
    *why = "not a fresh command: its ticket is not the newest";
    if ((hold ? m->as.hold.ticket : m->as.release.ticket) != h->ticket) return WIRE_STALE;
    if (!hold) return 0;
    *why = "the holder moves";
    if (h->state == WIRE_MOVING || h->state == WIRE_LETTING_GO) return WIRE_BUSY;
    *why = "the stop contact is open";
    if (hardware_stop_contact_is_open()) return WIRE_NACK_HOLDER;
    *why = "the displacement is outside this rig's limits";
    return holding_allows(m->as.hold.displacement, um) ? 0 : WIRE_LIMIT;
}

/* Carry out a HOLD or RELEASE; `next_sample` says which one is taken next. Returns as holding_refusal(). */
static inline uint8_t holding_obey(struct holding *h, const struct wire_message *m, uint64_t (*next_sample)(void),
                                   const char **why) {
    bool hold = m->type == WIRE_HOLD;
    uint32_t ticket = hold ? m->as.hold.ticket : m->as.release.ticket;
    int32_t um = 0;
    uint8_t code;
    if (h->done == m->type && h->done_ticket == ticket &&
        (!hold || (holding_allows(m->as.hold.displacement, &um) && um == h->um))) {
        h->has_news = true; /* its ACK was lost */
        return 0;
    }
    code = holding_refusal(h, m, &um, why);
    if (code) return code;
    if (hold) {
        holder_hold(&h->holder, um * hardware_holder.side);
        h->um = um;
    } else {
        holder_release(&h->holder);
        h->um = 0;
        h->released = next_sample();
    }
    holding_become(h, hold ? WIRE_MOVING : WIRE_FREE, WIRE_BY_REQUEST);
    h->done = m->type;
    h->done_ticket = ticket;
    return 0;
}

/* At each step of the main loop: silence, stop contact, what the carriage has reached. */
static inline void holding_watch(struct holding *h, uint64_t now) {
    uint8_t phase = h->holder.phase;
    if (now - h->heard >= HOLDING_SILENCE) {
        h->heard = now;
        holding_renew(h);
        holding_let_go_slowly(h, WIRE_BY_SILENCE);
    }
    if (hardware_stop_contact_is_open()) holding_let_go_slowly(h, WIRE_BY_CONTACT);
    if (h->state == WIRE_MOVING && phase == HOLDER_HOLDS) {
        h->state = WIRE_HELD;
        h->has_news = true;
    } else if (h->state == WIRE_MOVING && phase == HOLDER_STUCK) {
        h->um = 0;
        holding_become(h, WIRE_FREE, WIRE_BY_FAULT);
    } else if (h->state == WIRE_LETTING_GO && phase == HOLDER_FREE) {
        h->state = WIRE_FREE;
        h->has_news = true;
    }
}

static inline bool holding_report_is_due(const struct holding *h, uint64_t now) {
    return h->has_news || (h->state != WIRE_FREE && now - h->said >= HOLDING_REPORT);
}

static inline void holding_report(struct holding *h, struct wire_message *m, uint64_t now) {
    struct wire_holder *report = &m->as.holder;
    m->type = WIRE_HOLDER;
    report->low = hardware_holder.low_um * (wire_real)1e-6;
    report->high = hardware_holder.high_um * (wire_real)1e-6;
    report->silence_s = HOLDING_SILENCE_S;
    report->ticket = h->ticket;
    report->state = h->state;
    report->reason = h->reason;
    report->displacement = h->um * (wire_real)1e-6;
    report->sample = h->released;
    h->has_news = false;
    h->said = now;
}

#endif
