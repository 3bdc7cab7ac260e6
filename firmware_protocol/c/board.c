/* The board's side of the protocol: requests in, answers and samples out, one frame at a time. */
#include "board.h"

#include "hardware.h"
#include "holding.h"
#include "ring.h"
#include "timing.h"

#define HEARTBEAT (hardware_clock_hz / 2) /* while idle: half a second */
#define SILENCE (hardware_clock_hz / 4)   /* while sampling, when no DATA is due */
#define LATEST_DATA (hardware_clock_hz / 10) /* a sample waits no longer for its frame to fill */

enum state { IDLE, SAMPLING, FINISHING, RESENDING };

static struct ring ring;
static struct timing timing;
static struct wire_receiver receiver;

static struct {
    enum state state;
    uint32_t boot_id, sequence;
    uint32_t period; /* from sample to sample, in ticks of the clock, as all times here */
    uint16_t samples_per_frame;

    /* the capture */
    uint64_t first_at;       /* when sample 0 was taken */
    uint32_t next;           /* first sample that was not sent yet */
    uint32_t dropped_before; /* not sent since the last DATA */
    uint64_t dropped_total;  /* since boot */
    uint32_t unread;         /* samples that the sensors did not give */
    struct wire_end end;

    /* answers that wait for their turn */
    bool say_hello, say_describe, say_clock, say_answer, say_time, say_end, say_event, say_timing;
    struct wire_message answer; /* ACK or NACK */
    struct wire_event event;
    char timing_text[TIMING_TEXT];
    uint64_t host_time_us;
    uint32_t resend_next, resend_end;
    bool resend_incomplete;

    /* the frame on its way out */
    uint8_t out[WIRE_MAX_SENT];
    size_t out_length, out_at;
    uint64_t last_frame, last_data, last_heartbeat;
} board;

void board_sample(const int16_t *numbers, uint32_t ticks) { ring_put(&ring, numbers, ticks); }
void board_late(uint16_t ticks) { timing_note(&timing, ticks); }

static uint64_t microseconds(uint64_t ticks) {
    uint64_t seconds = ticks / hardware_clock_hz;
    uint32_t rest = (uint32_t)(ticks - seconds * hardware_clock_hz);
    return seconds * 1000000u + ((uint64_t)rest * 1000000u + hardware_clock_hz / 2) / hardware_clock_hz;
}

/* ---- Requests ---- */

static void acknowledge(const struct wire_frame *request) {
    board.say_answer = true;
    board.answer.type = WIRE_ACK;
    board.answer.as.ack.request_sequence = request->sequence;
    board.answer.as.ack.request_type = request->message.type;
}

static void refuse(const struct wire_frame *request, uint8_t code, const char *why) {
    board.say_answer = true;
    board.answer.type = WIRE_NACK;
    board.answer.as.nack.request_sequence = request->sequence;
    board.answer.as.nack.request_type = request->message.type;
    board.answer.as.nack.code = code;
    board.answer.as.nack.text = wire_text_of(why);
}

/* A sixteenth of a second, so that at high rates the frames' headers do not fill the line. */
static uint16_t usual_frame(uint32_t period) {
    uint32_t samples = hardware_clock_hz / 16 / period;
    if (samples < BOARD_SAMPLES_PER_FRAME) return BOARD_SAMPLES_PER_FRAME;
    return samples < BOARD_MOST_PER_FRAME ? (uint16_t)samples : BOARD_MOST_PER_FRAME;
}

static void configure(const struct wire_frame *request) {
    const struct wire_config *asked = &request->message.as.config;
    uint32_t period = hardware_period(asked->rate_hz);
    if (asked->format != WIRE_ANY_FORMAT && asked->format != WIRE_I16) {
        refuse(request, WIRE_UNSUPPORTED, "this board sends i16 only");
    } else if (period == 0 || (uint64_t)hardware_clock_hz * BOARD_KEEP_MS > (uint64_t)period * BOARD_RING * 1000u) {
        refuse(request, WIRE_UNSUPPORTED, "the sampling rate is out of this board's range");
    } else if (asked->samples_per_frame > BOARD_MOST_PER_FRAME) {
        refuse(request, WIRE_UNSUPPORTED, "so many samples do not fit a frame");
    } else {
        board.period = period;
        board.samples_per_frame = asked->samples_per_frame ? asked->samples_per_frame : usual_frame(period);
        acknowledge(request);
        board.say_describe = true;
    }
}

static void start(const struct wire_frame *request) {
    uint64_t count = request->message.as.start.count;
    memset(&board.end, 0, sizeof board.end);
    ring_clear(&ring, count == 0 || count > UINT32_MAX ? UINT32_MAX : (uint32_t)count);
    timing_clear(&timing);
    board.next = board.dropped_before = board.unread = 0;
    if (!hardware_start_sampling(board.period, &board.first_at)) {
        refuse(request, WIRE_SENSOR, "a sensor does not answer");
        return;
    }
    board.last_data = hardware_ticks();
    board.state = SAMPLING;
    holding_started();
    acknowledge(request);
}

static void finish(void) {
    hardware_stop_sampling();
    board.state = FINISHING;
    board.say_timing = timing_was_noted(&timing);
}

static void stop(const struct wire_frame *request) {
    holding_let_go_slowly(WIRE_BY_STOP);
    if (board.state == SAMPLING) {
        finish();
    } else if (board.state == IDLE) {
        board.say_end = true;
    }
    acknowledge(request);
}

static void resend(const struct wire_frame *request) {
    uint64_t first = request->message.as.resend.first, end = first + request->message.as.resend.count;
    uint32_t taken = ring_taken(&ring);
    board.resend_incomplete = end < first || end > taken;
    board.resend_next = first < taken ? (uint32_t)first : taken;
    board.resend_end = end >= first && end < taken ? (uint32_t)end : taken;
    board.state = RESENDING;
    acknowledge(request); /* sent after the samples */
}

static uint64_t next_sample(void) { return board.state == SAMPLING ? ring_taken(&ring) : WIRE_NO_SAMPLE; }

static void hold(const struct wire_frame *request) {
    const char *why;
    uint8_t code = holding_obey(&request->message, next_sample, &why);
    if (code) refuse(request, code, why);
    else acknowledge(request);
}

static void obey(const struct wire_frame *request) {
    bool idle = board.state == IDLE;
    if (request->stream != 0) return; /* this board has one stream */
    holding_hear(request, hardware_ticks());
    switch (request->message.type) {
    case WIRE_HELLO_REQUEST:
        board.say_hello = board.say_describe = true;
        break;
    case WIRE_TIMESYNC:
        board.say_time = true;
        board.host_time_us = request->message.as.timesync.host_time_us;
        break;
    case WIRE_STOP:
        stop(request);
        break;
    case WIRE_HOLD:
    case WIRE_RELEASE:
        hold(request);
        break;
    case WIRE_CONFIG:
    case WIRE_START:
    case WIRE_RESEND:
        if (!idle) refuse(request, WIRE_BUSY, "sampling; send STOP first");
        else if (request->message.type == WIRE_CONFIG) configure(request);
        else if (request->message.type == WIRE_START) start(request);
        else resend(request);
        break;
    default: /* what boards send: a line that echoes */
        break;
    }
}

static bool owes_an_answer(void) {
    return board.say_hello || board.say_describe || board.say_answer || board.say_time || board.say_end ||
           board.say_clock || board.state == RESENDING;
}

static void receive(void) {
    uint8_t byte;
    struct wire_frame request;
    while (!owes_an_answer() && hardware_receive(&byte, 1) == 1) {
        enum wire_result result = wire_receive(&receiver, byte, &request);
        if (result == WIRE_FRAME) obey(&request);
        else if (result == WIRE_OTHER_VERSION) board.say_hello = true;
        else if ((result == WIRE_UNKNOWN_TYPE || result == WIRE_MALFORMED) && request.message.type < 0x80)
            refuse(&request, WIRE_NOT_UNDERSTOOD, "");
    }
}

/* ---- What to send next ---- */

static void transmit(const struct wire_message *message) {
    board.out_length = wire_encode(board.out, message, board.sequence++, 0);
    board.out_at = 0;
    board.last_frame = hardware_ticks();
}

static void send_hello(void) {
    struct wire_message m;
    m.type = WIRE_HELLO;
    m.as.hello.major = WIRE_MAJOR;
    m.as.hello.minor = WIRE_MINOR;
    m.as.hello.reset_cause = hardware_reset_cause();
    m.as.hello.boot_id = board.boot_id;
    m.as.hello.clock_hz = hardware_clock_hz;
    m.as.hello.firmware = wire_text_of(hardware_firmware);
    m.as.hello.board = wire_text_of(hardware_board);
    m.as.hello.unique_id = wire_text_of(hardware_unique_id());
    transmit(&m);
}

static void send_describe(void) {
    struct wire_channel channels[BOARD_CHANNELS];
    struct wire_message m;
    int i;
    for (i = 0; i < BOARD_CHANNELS; i++) {
        channels[i] = hardware_channels[i];
        channels[i].rate_hz = (wire_real)hardware_clock_hz / (wire_real)board.period;
    }
    m.type = WIRE_DESCRIBE;
    m.as.describe.format = WIRE_I16;
    m.as.describe.count = BOARD_CHANNELS;
    m.as.describe.channels = channels;
    transmit(&m);
    if (board.out_length == 0) { /* too long for a frame: the station says so, but not why */
        m.type = WIRE_LOG;
        m.as.log.text = wire_text_of("DESCRIBE does not fit a frame: shorten its texts");
        transmit(&m);
    }
}

/* When a sample was taken: of all times that the lower 32 bits may stand for, the one nearest to even sampling. */
static uint64_t taken_at(uint32_t index) {
    uint64_t even = board.first_at + (uint64_t)index * board.period;
    int32_t later = (int32_t)(ring_time(&ring, index, board.period) - (uint32_t)even);
    return even + (uint64_t)(int64_t)later;
}

static void send_run(const struct ring_run *run, uint32_t dropped_before, const uint8_t *bytes) {
    struct wire_message m;
    m.type = WIRE_DATA;
    m.as.data.first_index = run->first;
    m.as.data.board_time_us = microseconds(taken_at(run->first));
    m.as.data.dropped_before = dropped_before;
    m.as.data.n = run->n;
    m.as.data.channels = BOARD_CHANNELS;
    m.as.data.format = WIRE_I16;
    m.as.data.samples = bytes;
    transmit(&m);
}

static void note_loss(const struct ring_run *run) {
    uint32_t lost = run->overrun + run->unread;
    if (lost == 0) return;
    board.dropped_before += lost;
    board.dropped_total += lost;
    board.unread += run->unread;
    board.end.total_dropped += lost;
    board.say_event = true;
    board.event.kind = run->overrun ? WIRE_OVERRUN : WIRE_SENSOR_FAULT;
    board.event.channel = WIRE_NO_CHANNEL;
    board.event.index = run->first - lost;
    board.event.count = lost;
    board.event.text = wire_text_of("");
}

/* Samples that were never sent, if a frame of them is due. */
static bool send_new_samples(uint64_t now) {
    uint8_t bytes[BOARD_MOST_PER_FRAME * RING_SAMPLE_BYTES];
    uint32_t waiting = ring_taken(&ring) - board.next;
    struct ring_run run;
    if (waiting == 0) return false;
    if (board.state == SAMPLING && waiting < board.samples_per_frame && now - board.last_data < LATEST_DATA)
        return false;
    run = ring_copy(&ring, board.next, board.next + waiting, board.samples_per_frame, bytes);
    note_loss(&run);
    board.next = run.first + run.n;
    if (run.n == 0) return false;
    board.end.checksum = wire_crc32(board.end.checksum, bytes, (size_t)run.n * RING_SAMPLE_BYTES);
    send_run(&run, board.dropped_before, bytes);
    board.dropped_before = 0;
    board.last_data = now;
    return true;
}

static bool send_samples_again(void) {
    uint8_t bytes[BOARD_MOST_PER_FRAME * RING_SAMPLE_BYTES];
    struct ring_run run =
        ring_copy(&ring, board.resend_next, board.resend_end, board.samples_per_frame, bytes);
    board.resend_next = run.first + run.n;
    board.resend_incomplete |= run.overrun + run.unread > 0;
    if (run.n == 0) {
        board.state = IDLE;
        if (board.resend_incomplete) {
            struct wire_ack asked = board.answer.as.ack;
            board.answer.type = WIRE_NACK;
            board.answer.as.nack.request_sequence = asked.request_sequence;
            board.answer.as.nack.request_type = asked.request_type;
            board.answer.as.nack.code = WIRE_NOT_HELD;
            board.answer.as.nack.text = wire_text_of("not all of these samples are held");
        }
        return false;
    }
    send_run(&run, 0, bytes);
    return true;
}

/* How evenly the capture was sampled: board_late() and the samples that could not be read. */
static void send_timing(void) {
    struct wire_message m;
    m.type = WIRE_EVENT;
    m.as.event.kind = WIRE_EVENT_OTHER;
    m.as.event.channel = WIRE_NO_CHANNEL;
    m.as.event.index = 0;
    m.as.event.count = board.unread;
    m.as.event.text.bytes = board.timing_text;
    m.as.event.text.length =
        timing_text(board.timing_text, &timing, hardware_clock_hz, board.unread, board.next);
    transmit(&m);
}

static void send_end(void) {
    struct wire_message m;
    m.type = WIRE_END;
    m.as.end = board.end;
    transmit(&m);
}

static void send_heartbeat(uint64_t now) {
    struct wire_message m;
    uint32_t waiting = ring_taken(&ring) - board.next;
    m.type = WIRE_HEARTBEAT;
    m.as.heartbeat.uptime_us = microseconds(now);
    m.as.heartbeat.buffer_fill_percent =
        (uint8_t)(waiting < BOARD_RING ? 100u * waiting / BOARD_RING : 100u);
    m.as.heartbeat.dropped_total = board.dropped_total;
    board.last_heartbeat = now;
    transmit(&m);
}

static bool take(bool *flag) {
    bool was = *flag;
    *flag = false;
    return was;
}

/* Answers first, HELLO before DESCRIBE and ACK before DESCRIBE and END; then samples; then signs of life. */
static void send_next(uint64_t now) {
    struct wire_message m;
    if (board.state == RESENDING && send_samples_again()) return;
    if (take(&board.say_hello)) {
        send_hello();
    } else if (take(&board.say_answer)) {
        transmit(&board.answer);
    } else if (take(&board.say_describe)) {
        send_describe();
        board.say_clock = hardware_clock_error_ppm > 0;
        holding_say();
    } else if (take(&board.say_clock)) {
        m.type = WIRE_CLOCK;
        m.as.clock.error_ppm = hardware_clock_error_ppm;
        transmit(&m);
    } else if (holding_report_is_due(now)) {
        holding_report(&m, now);
        transmit(&m);
    } else if (take(&board.say_time)) {
        m.type = WIRE_TIMESYNC;
        m.as.timesync.host_time_us = board.host_time_us;
        m.as.timesync.board_time_us = microseconds(now);
        transmit(&m);
    } else if (take(&board.say_end)) {
        send_end();
    } else if (take(&board.say_event)) {
        m.type = WIRE_EVENT;
        m.as.event = board.event;
        transmit(&m);
    } else if (board.state == IDLE) {
        if (now - board.last_heartbeat >= HEARTBEAT) send_heartbeat(now);
    } else if (send_new_samples(now)) {
        return;
    } else if (board.state == FINISHING && board.next == ring_taken(&ring)) {
        if (take(&board.say_timing)) {
            send_timing();
            return;
        }
        board.end.total_samples = board.next;
        board.state = IDLE;
        send_end();
    } else if (now - board.last_frame >= SILENCE) {
        send_heartbeat(now);
    }
}

/* ---- The loop ---- */

void board_begin(void) {
    board.boot_id = hardware_boot_id();
    board.period = hardware_period(0);
    board.samples_per_frame = usual_frame(board.period);
    holding_begin(board.boot_id);
}

void board_step(void) {
    receive();
    holding_watch(hardware_ticks());
    if (board.state == SAMPLING && ring_taken(&ring) >= ring.limit) finish();
    if (board.out_at == board.out_length) send_next(hardware_ticks());
    if (board.out_at < board.out_length)
        board.out_at += hardware_send(board.out + board.out_at, board.out_length - board.out_at);
}
