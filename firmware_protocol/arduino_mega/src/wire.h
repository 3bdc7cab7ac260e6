/* The wire between board and station: messages to frames and back. C99, one header, no allocation.
 *
 * Protocol 1.1, described in docs/protocol.md. Compiles as C99 and as C++11. Needs 8-bit bytes and an IEEE 754
 * `double` of 64 bits, or of 32 as on AVR: then the 64 bits on the wire are made of it, exactly, and rounded to
 * it. Does not depend on the byte order of the machine.
 *
 *   sending:    uint8_t out[WIRE_MAX_SENT];
 *               size_t n = wire_encode(out, &message, sequence++, 0);      0: does not fit
 *   receiving:  for each byte that comes:
 *               if (wire_receive(&receiver, byte, &frame) == WIRE_FRAME) { ... frame.message ... }
 *
 * Texts and samples of a received message point into the receiver's buffer, until the next byte.
 */
#ifndef WIRE_H
#define WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define WIRE_MAJOR 1
#define WIRE_MINOR 1
/* Header, body and checksum, before stuffing. A board that sends shorter frames may define less. */
#ifndef WIRE_MAX_FRAME
#define WIRE_MAX_FRAME 1024
#endif
#define WIRE_MAX_STUFFED (WIRE_MAX_FRAME + 5) /* one byte more for each 254 begun */
#define WIRE_MAX_SENT (WIRE_MAX_STUFFED + 1) /* and the closing zero */
#define WIRE_MIN_FRAME 12

/* A board receives nothing longer than CONFIG; it may define this as 64 before including and save 965 bytes. */
#ifndef WIRE_RECEIVE_MAX
#define WIRE_RECEIVE_MAX WIRE_MAX_STUFFED
#endif

/* The floating-point type of the fields written as f64. */
#ifdef WIRE_REAL
typedef WIRE_REAL wire_real;
#else
typedef double wire_real;
#endif
typedef char wire_real_has_32_or_64_bits[sizeof(wire_real) == 8 || sizeof(wire_real) == 4 ? 1 : -1];

enum wire_type {
    WIRE_HELLO_REQUEST = 0x01,
    WIRE_CONFIG = 0x02,
    WIRE_START = 0x03,
    WIRE_STOP = 0x04,
    WIRE_RESEND = 0x05,
    WIRE_TIMESYNC = 0x06,
    WIRE_HOLD = 0x07,
    WIRE_RELEASE = 0x08,
    WIRE_HELLO = 0x81,
    WIRE_DESCRIBE = 0x82,
    WIRE_ACK = 0x83,
    WIRE_NACK = 0x84,
    WIRE_DATA = 0x85,
    WIRE_HEARTBEAT = 0x86,
    WIRE_EVENT = 0x87,
    WIRE_END = 0x88,
    WIRE_LOG = 0x89,
    WIRE_CLOCK = 0x8A,
    WIRE_HOLDER = 0x8B
};

enum wire_format { WIRE_ANY_FORMAT = 0, WIRE_I16 = 1, WIRE_I32 = 2, WIRE_F32 = 3, WIRE_F64 = 4 };

enum wire_reset_cause {
    WIRE_RESET_POWER_ON = 1,
    WIRE_RESET_PIN = 2,
    WIRE_RESET_WATCHDOG = 3,
    WIRE_RESET_BROWNOUT = 4,
    WIRE_RESET_SOFTWARE = 5,
    WIRE_RESET_OTHER = 255
};

enum wire_nack_code {
    WIRE_NOT_UNDERSTOOD = 1,
    WIRE_BUSY = 2,
    WIRE_UNSUPPORTED = 3,
    WIRE_NOT_HELD = 4,
    WIRE_SENSOR = 5,
    WIRE_LIMIT = 6,
    WIRE_STALE = 7,
    WIRE_NOTHING_HELD = 8,
    WIRE_NACK_HOLDER = 9,
    WIRE_NACK_OTHER = 255
};

enum wire_event_kind {
    WIRE_OVERRUN = 1,
    WIRE_SATURATION = 2,
    WIRE_SENSOR_FAULT = 3,
    WIRE_EVENT_OTHER = 255
};

enum wire_holder_state {
    WIRE_FREE = 1,
    WIRE_MOVING = 2,
    WIRE_HELD = 3,
    WIRE_LETTING_GO = 4,
    WIRE_HOLDER_STATE_OTHER = 255
};

enum wire_holder_reason {
    WIRE_BY_BOOT = 1,
    WIRE_BY_REQUEST = 2,
    WIRE_BY_STOP = 3,
    WIRE_BY_SILENCE = 4,
    WIRE_BY_CONTACT = 5,
    WIRE_BY_FAULT = 6,
    WIRE_BY_OTHER = 255
};

#define WIRE_NO_CHANNEL 255
#define WIRE_NO_SAMPLE UINT64_MAX
/* What a DESCRIBE holds when all texts are empty: 16 in 1024 bytes. With 22 bytes of text each it holds 12. */
#define WIRE_MAX_CHANNELS ((WIRE_MAX_FRAME - 14) / 62)

/* UTF-8, not closed by a zero. */
struct wire_text {
    const char *bytes;
    uint8_t length;
};

struct wire_channel {
    wire_real scale, offset, rate_hz; /* value = scale * number + offset */
    wire_real low, high, resolution;  /* NaN: unknown */
    wire_real group_delay_s;
    struct wire_text name, quantity, unit, sensor;
};

struct wire_hello_request { uint8_t major, minor; };
struct wire_config { wire_real rate_hz; uint16_t samples_per_frame; uint8_t format; };
struct wire_start { uint64_t count; };
struct wire_resend { uint64_t first; uint32_t count; };
struct wire_timesync { uint64_t host_time_us, board_time_us; };
struct wire_hold { uint32_t ticket; wire_real displacement; };
struct wire_release { uint32_t ticket; };
struct wire_hello {
    uint8_t major, minor, reset_cause;
    uint32_t boot_id, clock_hz;
    struct wire_text firmware, board, unique_id;
};
struct wire_describe {
    uint8_t format, count;
    const struct wire_channel *channels; /* to encode */
    const uint8_t *records;              /* decoded: read them one by one with wire_next_channel */
    size_t records_length;
};
struct wire_ack { uint32_t request_sequence; uint8_t request_type; };
struct wire_nack { uint32_t request_sequence; uint8_t request_type, code; struct wire_text text; };
struct wire_data {
    uint64_t first_index, board_time_us;
    uint32_t dropped_before;
    uint16_t n;
    uint8_t channels, format;
    const uint8_t *samples; /* n * channels numbers, little-endian, sample by sample */
};
struct wire_heartbeat { uint64_t uptime_us; uint8_t buffer_fill_percent; uint64_t dropped_total; };
struct wire_event { uint8_t kind, channel; uint64_t index; uint32_t count; struct wire_text text; };
struct wire_end { uint64_t total_samples, total_dropped; uint32_t checksum; };
struct wire_log { struct wire_text text; };
struct wire_clock { wire_real error_ppm; };
struct wire_holder {
    wire_real low, high, silence_s;
    uint32_t ticket;
    uint8_t state, reason;
    wire_real displacement;
    uint64_t sample;
};

struct wire_message {
    uint8_t type; /* enum wire_type; STOP has no fields */
    union {
        struct wire_hello_request hello_request;
        struct wire_config config;
        struct wire_start start;
        struct wire_resend resend;
        struct wire_timesync timesync;
        struct wire_hold hold;
        struct wire_release release;
        struct wire_hello hello;
        struct wire_describe describe;
        struct wire_ack ack;
        struct wire_nack nack;
        struct wire_data data;
        struct wire_heartbeat heartbeat;
        struct wire_event event;
        struct wire_end end;
        struct wire_log log;
        struct wire_clock clock;
        struct wire_holder holder;
    } as;
};

struct wire_frame {
    uint8_t version, stream;
    uint32_t sequence;
    struct wire_message message;
};

static inline struct wire_text wire_text_of(const char *string) {
    struct wire_text text;
    size_t length = strlen(string);
    text.bytes = string;
    text.length = (uint8_t)(length < 255 ? length : 255);
    return text;
}

static inline size_t wire_format_size(uint8_t format) {
    return format == WIRE_I16 ? 2 : format == WIRE_I32 || format == WIRE_F32 ? 4 : format == WIRE_F64 ? 8 : 0;
}

/* CRC-32 as in zlib, continued: wire_crc32(0, ...) begins, wire_crc32(crc, ...) goes on. */
static inline uint32_t wire_crc32(uint32_t crc, const uint8_t *bytes, size_t count) {
    static const uint32_t half_byte[16] = {
        0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u, 0x4DB26158u, 0x5005713Cu,
        0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu, 0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu,
    };
    crc = ~crc;
    while (count--) {
        crc ^= *bytes++;
        crc = (crc >> 4) ^ half_byte[crc & 15];
        crc = (crc >> 4) ^ half_byte[crc & 15];
    }
    return ~crc;
}

/* ---- One frame being written (stuffed as it grows) or one body being read ---- */

struct wire_io {
    bool writing, failed;
    const uint8_t *at, *end; /* reading */
    uint8_t *out;            /* writing */
    size_t sent, plain, code_at;
    uint8_t code;
    bool block_is_full;
    uint32_t crc;
};

static inline void wire_open_block(struct wire_io *io) {
    io->code_at = io->sent++;
    io->code = 1;
    io->block_is_full = false;
}

static inline void wire_put(struct wire_io *io, uint8_t byte) {
    if (io->plain >= WIRE_MAX_FRAME) {
        io->failed = true;
        return;
    }
    io->plain++;
    io->crc = wire_crc32(io->crc, &byte, 1);
    if (io->block_is_full) wire_open_block(io);
    if (byte != 0) {
        io->out[io->sent++] = byte;
        io->code++;
        io->block_is_full = io->code == 255;
    }
    io->out[io->code_at] = io->code;
    if (byte == 0) wire_open_block(io);
}

static inline uint64_t wire_integer(struct wire_io *io, uint64_t value, int bytes) {
    int i;
    if (io->writing) {
        for (i = 0; i < bytes; i++, value >>= 8) wire_put(io, (uint8_t)value);
        return 0;
    }
    value = 0;
    if (io->end - io->at < bytes) {
        io->failed = true;
        return 0;
    }
    io->at += bytes;
    for (i = 1; i <= bytes; i++) value = value << 8 | io->at[-i];
    return value;
}

/* Each of these writes *value, or reads into it. What is being written may stand in read-only memory. */
static inline void wire_u8(struct wire_io *io, uint8_t *value) {
    uint64_t v = wire_integer(io, io->writing ? *value : 0, 1);
    if (!io->writing) *value = (uint8_t)v;
}
static inline void wire_u16(struct wire_io *io, uint16_t *value) {
    uint64_t v = wire_integer(io, io->writing ? *value : 0, 2);
    if (!io->writing) *value = (uint16_t)v;
}
static inline void wire_u32(struct wire_io *io, uint32_t *value) {
    uint64_t v = wire_integer(io, io->writing ? *value : 0, 4);
    if (!io->writing) *value = (uint32_t)v;
}
static inline void wire_u64(struct wire_io *io, uint64_t *value) {
    uint64_t v = wire_integer(io, io->writing ? *value : 0, 8);
    if (!io->writing) *value = v;
}

/* IEEE 754: the bits of the 64-bit number equal to a 32-bit one. */
static inline uint64_t wire_widened(uint32_t bits) {
    uint64_t sign = (uint64_t)(bits >> 31) << 63, fraction = bits & 0x7FFFFFu;
    uint16_t exponent = bits >> 23 & 255;
    if (exponent == 255) return sign | (uint64_t)0x7FF << 52 | fraction << 29; /* infinite, not a number */
    if (exponent == 0) {
        if (fraction == 0) return sign;
        for (exponent = 897; !(fraction & 0x800000u); exponent--) fraction <<= 1; /* subnormal */
        return sign | (uint64_t)exponent << 52 | (fraction & 0x7FFFFFu) << 29;
    }
    return sign | (uint64_t)(exponent + 896u) << 52 | fraction << 29;
}

/* The bits of the 32-bit number nearest to a 64-bit one, a tie to the even one. */
static inline uint32_t wire_narrowed(uint64_t bits) {
    uint32_t sign = (uint32_t)(bits >> 63) << 31, kept;
    uint64_t fraction = bits & (((uint64_t)1 << 52) - 1), rest, half;
    int exponent = (int)(bits >> 52 & 0x7FF) - 896, shift = 29;
    if (exponent == 2047 - 896)
        return sign | 0x7F800000u | (fraction ? 0x400000u : 0) | (uint32_t)(fraction >> 29);
    if (exponent >= 255) return sign | 0x7F800000u;
    if (exponent < -23) return sign;
    if (exponent <= 0) { /* subnormal */
        fraction |= (uint64_t)1 << 52;
        shift += 1 - exponent;
        exponent = 0;
    }
    kept = (uint32_t)(fraction >> shift);
    rest = fraction & (((uint64_t)1 << shift) - 1);
    half = (uint64_t)1 << (shift - 1);
    if (rest > half || (rest == half && (kept & 1))) kept++;
    return sign | (((uint32_t)exponent << 23) + kept);
}

static inline void wire_f64(struct wire_io *io, wire_real *value) {
    uint64_t bits = 0;
    uint32_t narrow = 0;
    if (io->writing && sizeof *value == sizeof bits) {
        memcpy(&bits, value, sizeof *value);
    } else if (io->writing) {
        memcpy(&narrow, value, sizeof narrow);
        bits = wire_widened(narrow);
    }
    bits = wire_integer(io, bits, 8);
    if (io->writing) return;
    narrow = wire_narrowed(bits);
    memcpy(value, sizeof *value == sizeof bits ? (const void *)&bits : (const void *)&narrow, sizeof *value);
}
static inline void wire_raw(struct wire_io *io, const uint8_t **bytes, size_t count) {
    size_t i;
    if (io->writing) {
        for (i = 0; i < count && !io->failed; i++) wire_put(io, (*bytes)[i]);
    } else if ((size_t)(io->end - io->at) < count) {
        io->failed = true;
    } else {
        *bytes = io->at;
        io->at += count;
    }
}
static inline void wire_text(struct wire_io *io, struct wire_text *text) {
    const uint8_t *bytes = io->writing ? (const uint8_t *)text->bytes : NULL;
    uint8_t length = io->writing ? text->length : 0;
    wire_u8(io, &length);
    wire_raw(io, &bytes, length);
    if (!io->writing) {
        text->bytes = (const char *)bytes;
        text->length = io->failed ? 0 : length;
    }
}

/* ---- The byte table: the fields of each message in their order, for both directions ---- */

static inline void wire_channel_fields(struct wire_io *io, struct wire_channel *m) {
    wire_f64(io, &m->scale);
    wire_f64(io, &m->offset);
    wire_f64(io, &m->rate_hz);
    wire_f64(io, &m->low);
    wire_f64(io, &m->high);
    wire_f64(io, &m->resolution);
    wire_f64(io, &m->group_delay_s);
    wire_text(io, &m->name);
    wire_text(io, &m->quantity);
    wire_text(io, &m->unit);
    wire_text(io, &m->sensor);
}

/* Read the next channel of a decoded DESCRIBE; `at` is 0 at first and moves on. False when it is cut short. */
static inline bool wire_next_channel(const struct wire_describe *m, size_t *at, struct wire_channel *channel) {
    struct wire_io io;
    size_t length;
    memset(&io, 0, sizeof io);
    if (m->records_length - *at < 2) return false;
    length = (size_t)m->records[*at] | (size_t)m->records[*at + 1] << 8;
    *at += 2;
    if (m->records_length - *at < length) return false;
    io.at = m->records + *at;
    io.end = io.at + length;
    *at += length;
    wire_channel_fields(&io, channel);
    return !io.failed;
}

static inline void wire_describe_fields(struct wire_io *io, struct wire_describe *m) {
    struct wire_channel channel;
    size_t at = 0;
    uint8_t i;
    wire_u8(io, &m->format);
    wire_u8(io, &m->count);
    if (io->writing) {
        for (i = 0; i < m->count; i++) {
            uint16_t length;
            channel = m->channels[i];
            length = (uint16_t)(7 * 8 + 4 + channel.name.length + channel.quantity.length +
                                channel.unit.length + channel.sensor.length);
            wire_u16(io, &length);
            wire_channel_fields(io, &channel);
        }
        return;
    }
    m->channels = NULL;
    m->records = io->at;
    m->records_length = (size_t)(io->end - io->at);
    io->failed |= wire_format_size(m->format) == 0;
    for (i = 0; i < m->count && !io->failed; i++) io->failed |= !wire_next_channel(m, &at, &channel);
}

static inline void wire_data_fields(struct wire_io *io, struct wire_data *m) {
    uint32_t count;
    wire_u64(io, &m->first_index);
    wire_u64(io, &m->board_time_us);
    wire_u32(io, &m->dropped_before);
    wire_u16(io, &m->n);
    wire_u8(io, &m->channels);
    wire_u8(io, &m->format);
    io->failed |= wire_format_size(m->format) == 0;
    count = (uint32_t)m->n * m->channels * (uint32_t)wire_format_size(m->format);
    if (count > WIRE_MAX_FRAME) io->failed = true;
    else wire_raw(io, &m->samples, (size_t)count);
}

static inline void wire_hello_fields(struct wire_io *io, struct wire_hello *m) {
    wire_u8(io, &m->major);
    wire_u8(io, &m->minor);
    wire_u8(io, &m->reset_cause);
    wire_u32(io, &m->boot_id);
    wire_u32(io, &m->clock_hz);
    wire_text(io, &m->firmware);
    wire_text(io, &m->board);
    wire_text(io, &m->unique_id);
}

static inline void wire_holder_fields(struct wire_io *io, struct wire_holder *m) {
    wire_f64(io, &m->low);
    wire_f64(io, &m->high);
    wire_f64(io, &m->silence_s);
    wire_u32(io, &m->ticket);
    wire_u8(io, &m->state);
    wire_u8(io, &m->reason);
    wire_f64(io, &m->displacement);
    wire_u64(io, &m->sample);
}

/* False when the type is unknown. */
static inline bool wire_fields(struct wire_io *io, struct wire_message *m) {
    switch (m->type) {
    case WIRE_HELLO_REQUEST:
        wire_u8(io, &m->as.hello_request.major);
        wire_u8(io, &m->as.hello_request.minor);
        return true;
    case WIRE_CONFIG:
        wire_f64(io, &m->as.config.rate_hz);
        wire_u16(io, &m->as.config.samples_per_frame);
        wire_u8(io, &m->as.config.format);
        if (m->as.config.format != WIRE_ANY_FORMAT) io->failed |= wire_format_size(m->as.config.format) == 0;
        return true;
    case WIRE_START:
        wire_u64(io, &m->as.start.count);
        return true;
    case WIRE_STOP:
        return true;
    case WIRE_RESEND:
        wire_u64(io, &m->as.resend.first);
        wire_u32(io, &m->as.resend.count);
        return true;
    case WIRE_TIMESYNC:
        wire_u64(io, &m->as.timesync.host_time_us);
        wire_u64(io, &m->as.timesync.board_time_us);
        return true;
    case WIRE_HOLD:
        wire_u32(io, &m->as.hold.ticket);
        wire_f64(io, &m->as.hold.displacement);
        return true;
    case WIRE_RELEASE:
        wire_u32(io, &m->as.release.ticket);
        return true;
    case WIRE_HELLO:
        wire_hello_fields(io, &m->as.hello);
        return true;
    case WIRE_DESCRIBE:
        wire_describe_fields(io, &m->as.describe);
        return true;
    case WIRE_ACK:
        wire_u32(io, &m->as.ack.request_sequence);
        wire_u8(io, &m->as.ack.request_type);
        return true;
    case WIRE_NACK:
        wire_u32(io, &m->as.nack.request_sequence);
        wire_u8(io, &m->as.nack.request_type);
        wire_u8(io, &m->as.nack.code);
        wire_text(io, &m->as.nack.text);
        return true;
    case WIRE_DATA:
        wire_data_fields(io, &m->as.data);
        return true;
    case WIRE_HEARTBEAT:
        wire_u64(io, &m->as.heartbeat.uptime_us);
        wire_u8(io, &m->as.heartbeat.buffer_fill_percent);
        wire_u64(io, &m->as.heartbeat.dropped_total);
        return true;
    case WIRE_EVENT:
        wire_u8(io, &m->as.event.kind);
        wire_u8(io, &m->as.event.channel);
        wire_u64(io, &m->as.event.index);
        wire_u32(io, &m->as.event.count);
        wire_text(io, &m->as.event.text);
        return true;
    case WIRE_END:
        wire_u64(io, &m->as.end.total_samples);
        wire_u64(io, &m->as.end.total_dropped);
        wire_u32(io, &m->as.end.checksum);
        return true;
    case WIRE_LOG:
        wire_text(io, &m->as.log.text);
        return true;
    case WIRE_CLOCK:
        wire_f64(io, &m->as.clock.error_ppm);
        return true;
    case WIRE_HOLDER:
        wire_holder_fields(io, &m->as.holder);
        return true;
    default:
        return false;
    }
}

/* ---- Sending ---- */

/* Write the whole frame, with its closing zero, and return its length; 0 when the message does not fit. */
static inline size_t wire_encode(uint8_t out[WIRE_MAX_SENT], const struct wire_message *message,
                                 uint32_t sequence, uint8_t stream) {
    struct wire_io io;
    uint32_t crc;
    memset(&io, 0, sizeof io);
    io.writing = true;
    io.out = out;
    wire_open_block(&io);
    wire_put(&io, WIRE_MAJOR);
    wire_put(&io, message->type);
    wire_put(&io, 0);
    wire_put(&io, stream);
    wire_u32(&io, &sequence);
    /* Nothing is written through this pointer while io.writing is set. */
    if (!wire_fields(&io, (struct wire_message *)message)) return 0;
    crc = io.crc;
    wire_u32(&io, &crc);
    if (io.failed) return 0;
    out[io.code_at] = io.code;
    out[io.sent++] = 0;
    return io.sent;
}

/* ---- Receiving ---- */

enum wire_result {
    WIRE_MORE,          /* the frame is not finished, or was empty */
    WIRE_FRAME,         /* here it is */
    WIRE_OTHER_VERSION, /* a sound frame of another major version: only `version` and the header count */
    WIRE_UNKNOWN_TYPE,  /* a sound frame of a type that this version does not know; the header counts */
    WIRE_MALFORMED,     /* a sound checksum around a body that makes no message; the header counts */
    WIRE_BAD_COBS,
    WIRE_BAD_CHECKSUM,
    WIRE_TOO_SHORT,
    WIRE_TOO_LONG
};

struct wire_receiver {
    uint8_t bytes[WIRE_RECEIVE_MAX];
    size_t length;
    bool overlong;
};

/* Undo the stuffing in place; return the plain length, or -1 when the bytes are not COBS. */
static inline long wire_unstuff(uint8_t *bytes, size_t length) {
    size_t from = 0, to = 0;
    while (from < length) {
        uint8_t code = bytes[from++];
        if (code == 0 || (size_t)(code - 1) > length - from) return -1;
        memmove(bytes + to, bytes + from, (size_t)(code - 1));
        to += (size_t)(code - 1);
        from += (size_t)(code - 1);
        if (code != 255 && from < length) bytes[to++] = 0;
    }
    return (long)to;
}

/* Read the plain frame: header, body and checksum. */
static inline enum wire_result wire_read(const uint8_t *plain, size_t length, struct wire_frame *frame) {
    struct wire_io io;
    uint8_t flags;
    uint32_t crc;
    memset(&io, 0, sizeof io);
    memset(frame, 0, sizeof *frame);
    if (length < WIRE_MIN_FRAME) return WIRE_TOO_SHORT;
    if (length > WIRE_MAX_FRAME) return WIRE_TOO_LONG;
    io.at = plain + length - 4;
    io.end = plain + length;
    wire_u32(&io, &crc);
    if (crc != wire_crc32(0, plain, length - 4)) return WIRE_BAD_CHECKSUM;
    io.at = plain;
    io.end = plain + length - 4;
    wire_u8(&io, &frame->version);
    wire_u8(&io, &frame->message.type);
    wire_u8(&io, &flags);
    wire_u8(&io, &frame->stream);
    wire_u32(&io, &frame->sequence);
    if (frame->version != WIRE_MAJOR) return WIRE_OTHER_VERSION;
    if (!wire_fields(&io, &frame->message)) return WIRE_UNKNOWN_TYPE;
    return io.failed ? WIRE_MALFORMED : WIRE_FRAME;
}

/* Take one byte. Whatever comes, in whatever order, is safe. A receiver begins with all bytes zero. */
static inline enum wire_result wire_receive(struct wire_receiver *receiver, uint8_t byte,
                                            struct wire_frame *frame) {
    size_t length = receiver->length;
    bool overlong = receiver->overlong;
    long plain;
    if (byte != 0) {
        if (length == WIRE_RECEIVE_MAX) receiver->overlong = true;
        else receiver->bytes[receiver->length++] = byte;
        return WIRE_MORE;
    }
    receiver->length = 0;
    receiver->overlong = false;
    if (overlong) return WIRE_TOO_LONG;
    if (length == 0) return WIRE_MORE;
    plain = wire_unstuff(receiver->bytes, length);
    return plain < 0 ? WIRE_BAD_COBS : wire_read(receiver->bytes, (size_t)plain, frame);
}

#endif
