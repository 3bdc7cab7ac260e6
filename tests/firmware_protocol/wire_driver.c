/* A line in, a line out, so that a test can ask the C side what it makes of messages and of bytes.
 *
 *   E type sequence stream field ...   encode; prints the frame in hexadecimal, or - when it does not fit
 *   D hexadecimal                      receive these bytes; prints what came of them, `; ` in between
 *
 * Fields stand in the order of the Python dataclasses: integers in decimal, doubles as the 16 hexadecimal
 * digits of their bits, texts and samples in hexadecimal behind a `=`. DESCRIBE: format, number of channels,
 * then each channel's fields.
 */
#include <stdio.h>
#include <stdlib.h>

#include "wire.h"

static char line[1 << 16];
static char *cursor;
static uint8_t store[1 << 15];
static size_t stored;
static struct wire_channel channels[32];

static uint64_t integer(void) { return strtoull(cursor, &cursor, 10); }

static double real(void) {
    uint64_t bits = strtoull(cursor, &cursor, 16);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static int digit(int c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1; }

static size_t bytes(const uint8_t **at) {
    size_t begin = stored;
    while (*cursor == ' ') cursor++;
    if (*cursor == '=') cursor++;
    *at = store + begin;
    while (digit(cursor[0]) >= 0 && digit(cursor[1]) >= 0 && stored < sizeof store) {
        store[stored++] = (uint8_t)(digit(cursor[0]) << 4 | digit(cursor[1]));
        cursor += 2;
    }
    return stored - begin;
}

static struct wire_text text(void) {
    struct wire_text value;
    const uint8_t *at;
    value.length = (uint8_t)bytes(&at);
    value.bytes = (const char *)at;
    return value;
}

static void read_channel(struct wire_channel *c) {
    c->name = text();
    c->quantity = text();
    c->unit = text();
    c->scale = real();
    c->offset = real();
    c->rate_hz = real();
    c->low = real();
    c->high = real();
    c->resolution = real();
    c->group_delay_s = real();
    c->sensor = text();
}

static void read_message(struct wire_message *m) {
    int i;
    switch (m->type) {
    case WIRE_HELLO_REQUEST:
        m->as.hello_request.major = (uint8_t)integer();
        m->as.hello_request.minor = (uint8_t)integer();
        break;
    case WIRE_CONFIG:
        m->as.config.rate_hz = real();
        m->as.config.samples_per_frame = (uint16_t)integer();
        m->as.config.format = (uint8_t)integer();
        break;
    case WIRE_START:
        m->as.start.count = integer();
        break;
    case WIRE_RESEND:
        m->as.resend.first = integer();
        m->as.resend.count = (uint32_t)integer();
        break;
    case WIRE_TIMESYNC:
        m->as.timesync.host_time_us = integer();
        m->as.timesync.board_time_us = integer();
        break;
    case WIRE_HOLD:
        m->as.hold.ticket = (uint32_t)integer();
        m->as.hold.displacement = real();
        break;
    case WIRE_RELEASE:
        m->as.release.ticket = (uint32_t)integer();
        break;
    case WIRE_HOLDER:
        m->as.holder.low = real();
        m->as.holder.high = real();
        m->as.holder.silence_s = real();
        m->as.holder.ticket = (uint32_t)integer();
        m->as.holder.state = (uint8_t)integer();
        m->as.holder.reason = (uint8_t)integer();
        m->as.holder.displacement = real();
        m->as.holder.sample = integer();
        break;
    case WIRE_HELLO:
        m->as.hello.boot_id = (uint32_t)integer();
        m->as.hello.clock_hz = (uint32_t)integer();
        m->as.hello.reset_cause = (uint8_t)integer();
        m->as.hello.major = (uint8_t)integer();
        m->as.hello.minor = (uint8_t)integer();
        m->as.hello.firmware = text();
        m->as.hello.board = text();
        m->as.hello.unique_id = text();
        break;
    case WIRE_DESCRIBE:
        m->as.describe.format = (uint8_t)integer();
        m->as.describe.count = (uint8_t)integer();
        m->as.describe.channels = channels;
        for (i = 0; i < m->as.describe.count; i++) read_channel(&channels[i]);
        break;
    case WIRE_ACK:
        m->as.ack.request_sequence = (uint32_t)integer();
        m->as.ack.request_type = (uint8_t)integer();
        break;
    case WIRE_NACK:
        m->as.nack.request_sequence = (uint32_t)integer();
        m->as.nack.request_type = (uint8_t)integer();
        m->as.nack.code = (uint8_t)integer();
        m->as.nack.text = text();
        break;
    case WIRE_DATA:
        m->as.data.first_index = integer();
        m->as.data.board_time_us = integer();
        m->as.data.dropped_before = (uint32_t)integer();
        m->as.data.n = (uint16_t)integer();
        m->as.data.channels = (uint8_t)integer();
        m->as.data.format = (uint8_t)integer();
        bytes(&m->as.data.samples);
        break;
    case WIRE_HEARTBEAT:
        m->as.heartbeat.uptime_us = integer();
        m->as.heartbeat.buffer_fill_percent = (uint8_t)integer();
        m->as.heartbeat.dropped_total = integer();
        break;
    case WIRE_EVENT:
        m->as.event.kind = (uint8_t)integer();
        m->as.event.index = integer();
        m->as.event.count = (uint32_t)integer();
        m->as.event.channel = (uint8_t)integer();
        m->as.event.text = text();
        break;
    case WIRE_END:
        m->as.end.total_samples = integer();
        m->as.end.total_dropped = integer();
        m->as.end.checksum = (uint32_t)integer();
        break;
    case WIRE_CLOCK:
        m->as.clock.error_ppm = real();
        break;
    case WIRE_LOG:
        m->as.log.text = text();
        break;
    default:
        break;
    }
}

static void show_hex(const uint8_t *at, size_t count) {
    while (count--) printf("%02x", *at++);
}
static void show(uint64_t value) { printf(" %llu", (unsigned long long)value); }
static void show_real(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    printf(" %016llx", (unsigned long long)bits);
}
static void show_bytes(const uint8_t *at, size_t count) {
    printf(" =");
    show_hex(at, count);
}
static void show_text(struct wire_text value) { show_bytes((const uint8_t *)value.bytes, value.length); }

static void show_channel(const struct wire_channel *c) {
    show_text(c->name);
    show_text(c->quantity);
    show_text(c->unit);
    show_real(c->scale);
    show_real(c->offset);
    show_real(c->rate_hz);
    show_real(c->low);
    show_real(c->high);
    show_real(c->resolution);
    show_real(c->group_delay_s);
    show_text(c->sensor);
}

static void show_frame(const struct wire_frame *frame) {
    const struct wire_message *m = &frame->message;
    struct wire_channel channel;
    size_t at = 0;
    int i;
    printf("%u %u %u", (unsigned)m->type, (unsigned)frame->sequence, (unsigned)frame->stream);
    switch (m->type) {
    case WIRE_HELLO_REQUEST:
        show(m->as.hello_request.major);
        show(m->as.hello_request.minor);
        break;
    case WIRE_CONFIG:
        show_real(m->as.config.rate_hz);
        show(m->as.config.samples_per_frame);
        show(m->as.config.format);
        break;
    case WIRE_START:
        show(m->as.start.count);
        break;
    case WIRE_RESEND:
        show(m->as.resend.first);
        show(m->as.resend.count);
        break;
    case WIRE_TIMESYNC:
        show(m->as.timesync.host_time_us);
        show(m->as.timesync.board_time_us);
        break;
    case WIRE_HOLD:
        show(m->as.hold.ticket);
        show_real(m->as.hold.displacement);
        break;
    case WIRE_RELEASE:
        show(m->as.release.ticket);
        break;
    case WIRE_HOLDER:
        show_real(m->as.holder.low);
        show_real(m->as.holder.high);
        show_real(m->as.holder.silence_s);
        show(m->as.holder.ticket);
        show(m->as.holder.state);
        show(m->as.holder.reason);
        show_real(m->as.holder.displacement);
        show(m->as.holder.sample);
        break;
    case WIRE_HELLO:
        show(m->as.hello.boot_id);
        show(m->as.hello.clock_hz);
        show(m->as.hello.reset_cause);
        show(m->as.hello.major);
        show(m->as.hello.minor);
        show_text(m->as.hello.firmware);
        show_text(m->as.hello.board);
        show_text(m->as.hello.unique_id);
        break;
    case WIRE_DESCRIBE:
        show(m->as.describe.format);
        show(m->as.describe.count);
        for (i = 0; i < m->as.describe.count && wire_next_channel(&m->as.describe, &at, &channel); i++)
            show_channel(&channel);
        break;
    case WIRE_ACK:
        show(m->as.ack.request_sequence);
        show(m->as.ack.request_type);
        break;
    case WIRE_NACK:
        show(m->as.nack.request_sequence);
        show(m->as.nack.request_type);
        show(m->as.nack.code);
        show_text(m->as.nack.text);
        break;
    case WIRE_DATA:
        show(m->as.data.first_index);
        show(m->as.data.board_time_us);
        show(m->as.data.dropped_before);
        show(m->as.data.n);
        show(m->as.data.channels);
        show(m->as.data.format);
        show_bytes(m->as.data.samples,
                   (size_t)m->as.data.n * m->as.data.channels * wire_format_size(m->as.data.format));
        break;
    case WIRE_HEARTBEAT:
        show(m->as.heartbeat.uptime_us);
        show(m->as.heartbeat.buffer_fill_percent);
        show(m->as.heartbeat.dropped_total);
        break;
    case WIRE_EVENT:
        show(m->as.event.kind);
        show(m->as.event.index);
        show(m->as.event.count);
        show(m->as.event.channel);
        show_text(m->as.event.text);
        break;
    case WIRE_END:
        show(m->as.end.total_samples);
        show(m->as.end.total_dropped);
        show(m->as.end.checksum);
        break;
    case WIRE_CLOCK:
        show_real(m->as.clock.error_ppm);
        break;
    case WIRE_LOG:
        show_text(m->as.log.text);
        break;
    default:
        break;
    }
}

static void encode_line(void) {
    uint8_t out[WIRE_MAX_SENT];
    struct wire_message message;
    uint32_t sequence;
    uint8_t stream;
    size_t count;
    memset(&message, 0, sizeof message);
    message.type = (uint8_t)integer();
    sequence = (uint32_t)integer();
    stream = (uint8_t)integer();
    read_message(&message);
    count = wire_encode(out, &message, sequence, stream);
    if (count == 0) printf("-");
    show_hex(out, count);
}

static void decode_line(void) {
    static struct wire_receiver receiver;
    static const char *names[] = {"more",     "frame",        "other version", "unknown",  "malformed",
                                  "bad cobs", "bad checksum", "too short",     "too long"};
    struct wire_frame frame;
    const uint8_t *at;
    size_t count = bytes(&at), results = 0;
    for (; count--; at++) {
        enum wire_result result = wire_receive(&receiver, *at, &frame);
        if (result == WIRE_MORE) continue;
        if (results++) printf("; ");
        if (result == WIRE_FRAME) show_frame(&frame);
        else printf("%s", names[result]);
    }
}

int main(void) {
    while (fgets(line, sizeof line, stdin)) {
        cursor = line + 1;
        stored = 0;
        if (line[0] == 'E') encode_line();
        else decode_line();
        putchar('\n');
    }
    return 0;
}
