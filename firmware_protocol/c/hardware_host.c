/* The hardware layer for a computer: a pseudo-terminal for the port, closed-form physics for the sensors.
 *
 * A mass of 21.36 kg on springs of 13115 N/m with dry and viscous friction (0.13 m/s^2 and 0.277 1/s, the
 * means of the paper's nine releases) is held at 20 mm and let go some seconds after each START. Between two
 * turning points the sign of the velocity does not change, so the motion is a damped cosine about a centre
 * that friction shifts by mu_0 / w0^2: no integration is needed.
 *
 *   hardware_host [--speed X] [--rest SECONDS] [--sensor-fault FIRST COUNT] [--pause FIRST SECONDS]
 *
 * prints `port: PATH` and runs until its standard input is closed.
 *
 * Compiled with -DBOARD_HOLDER=1 the mass rests at 0 instead, until the host has it held and let go by a magnet on a
 * carriage. Then a line `open` or `close` on the standard input is the stop contact, `hang up` drops DTR, and `block`
 * keeps the carriage from moving.
 */
#define _XOPEN_SOURCE 600
#include "hardware.h"

#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#define PI 3.14159265358979323846

static const double mass = 21.36, stiffness = 13115, dry = 0.13, viscous = 0.277;
#if !BOARD_HOLDER
static const double start_at = 0.020;
#endif
static const double displacement_lag_s = 0.0013; /* the filter of the displacement sensor */
static const double displacement_noise = 5e-6, acceleration_noise = 0.01;

static double speed = 1, rest_s = 3, now_s; /* since boot */
static uint32_t fault_first, fault_count;
static uint32_t pause_first = UINT32_MAX;
static double pause_s; /* no sample is taken for so long, and none is counted */

const char hardware_firmware[] = "example firmware 1.0";
const char hardware_board[] = "hardware_host";
const uint32_t hardware_clock_hz = 16000000;
const wire_real hardware_clock_error_ppm = 50;

#define TEXT(s) {s, sizeof s - 1}
const struct wire_channel hardware_channels[BOARD_CHANNELS] = {
    {1e-6, 0, 0, -0.032768, 0.032767, 1e-6, 0, TEXT("x"), TEXT("displacement"), TEXT("m"), TEXT("simulated 1")},
    {6e-4, 0, 0, -19.6608, 19.6602, 6e-4, 0, TEXT("a"), TEXT("acceleration"), TEXT("m/s^2"), TEXT("simulated 2")},
};

/* ---- The mass on springs ---- */

struct motion {
    double x, v, a;
};

/* `t` seconds after it was let go at `start_at`. */
static struct motion motion_from(double start_at, double t) {
    double w0 = sqrt(stiffness / mass), decay = viscous / 2, w = sqrt(w0 * w0 - decay * decay);
    double shift = dry / (w0 * w0), half = PI / w, from = start_at, sign, y, c, s, e;
    struct motion m = {start_at, 0, 0};
    if (t < 0) return m;
    for (;;) {
        m.x = from;
        m.v = m.a = 0;
        if (fabs(from) <= shift) return m; /* stuck */
        sign = from > 0 ? -1 : 1;          /* of the velocity until the next turning point */
        y = from + sign * shift;
        if (t < half) break;
        from = -sign * shift - y * exp(-decay * half);
        t -= half;
    }
    e = exp(-decay * t);
    c = cos(w * t);
    s = sin(w * t);
    m.x = -sign * shift + y * e * (c + decay / w * s);
    m.v = -y * e * w0 * w0 / w * s;
    m.a = -w0 * w0 * m.x - viscous * m.v - sign * dry;
    return m;
}

#if BOARD_HOLDER
/* ---- The magnet on its carriage, 3 mm from the end switch when the board boots ---- */

static int32_t carriage = 2700; /* steps of 10 um, from where the magnet touches the mass at rest */
static bool magnet, contact_is_open, stepping, blocked;
static double mass_at = 0, let_go_at = -1e9; /* let go at mass_at, in seconds since boot */

const struct hardware_holder hardware_holder = {0, 25000, 1, 30000, 1000, 100, 500};

static struct motion motion_at(double t) {
    struct motion held = {mass_at, 0, 0};
    return magnet ? held : motion_from(mass_at, t - let_go_at);
}

void hardware_holder_clock(bool runs) { stepping = runs; }

void hardware_holder_step(bool outward) {
    if (!blocked) carriage += outward ? 1 : -1;
    if (magnet) mass_at = carriage * 1e-5;
}

/* It grips a mass that it touches, and only then. */
void hardware_holder_magnet(bool on) {
    if (on == magnet) return;
    if (on && fabs(motion_at(now_s).x - carriage * 1e-5) > 2e-4) return;
    if (on) mass_at = carriage * 1e-5;
    let_go_at = now_s;
    magnet = on;
}

bool hardware_holder_at_end(void) { return carriage >= 3000; }
bool hardware_stop_contact_is_open(void) { return contact_is_open; }
#else
static struct motion motion_at(double t) { return motion_from(start_at, t); } /* seconds since it was let go */
#endif

/* ---- The sensors ---- */

static uint32_t random_state = 2463534242u;

static double uniform(void) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state / 4294967296.0;
}

static double normal(void) {
    double sum = -6;
    int i;
    for (i = 0; i < 12; i++) sum += uniform();
    return sum;
}

static int16_t converted(double value, const struct wire_channel *channel) {
    double number = floor((value - channel->offset) / channel->scale + 0.5);
    return (int16_t)(number > 32767 ? 32767 : number < -32768 ? -32768 : number);
}

static void take_sample(double t, uint32_t index, uint64_t now) {
    int16_t numbers[BOARD_CHANNELS];
    double x = motion_at(t - displacement_lag_s).x, a = motion_at(t).a;
    numbers[0] = converted(x + displacement_noise * normal(), &hardware_channels[0]);
    numbers[1] = converted(a + acceleration_noise * normal(), &hardware_channels[1]);
    board_sample(index - fault_first < fault_count ? NULL : numbers, (uint32_t)now);
}

static bool sampling;
static uint32_t sampling_period;
static uint64_t sampling_since, paused;
static uint32_t ticks;

uint32_t hardware_period(wire_real asked_hz) {
    if (asked_hz == 0) asked_hz = 256;
    return asked_hz >= 5 && asked_hz <= 256 ? (uint32_t)(hardware_clock_hz / asked_hz + 0.5) : 0;
}

bool hardware_start_sampling(uint32_t period, uint64_t *first) {
    sampling = true;
    sampling_period = period;
    ticks = 0;
    paused = 0;
    *first = sampling_since = hardware_ticks();
    return true;
}

void hardware_stop_sampling(void) { sampling = false; }

/* ---- Clock, port, identity ---- */

static int port = -1;
static double began;

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

uint64_t hardware_ticks(void) { return (uint64_t)((seconds() - began) * speed * hardware_clock_hz); }

uint32_t hardware_boot_id(void) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (uint32_t)now.tv_nsec * 2654435761u ^ (uint32_t)now.tv_sec ^ (uint32_t)getpid() << 16;
}

uint8_t hardware_reset_cause(void) { return WIRE_RESET_POWER_ON; }
const char *hardware_unique_id(void) { return "host-1"; }

size_t hardware_receive(uint8_t *bytes, size_t room) {
    ssize_t count = read(port, bytes, room);
    return count > 0 ? (size_t)count : 0;
}

size_t hardware_send(const uint8_t *bytes, size_t count) {
    ssize_t done = write(port, bytes, count);
    return done > 0 ? (size_t)done : 0;
}

#if BOARD_HOLDER
/* The carriage's steps up to `now`, in ticks of the clock; a sample may be due a little before the last step. */
static void step_until(uint64_t now) {
    static uint64_t stepped;
    uint64_t every = hardware_clock_hz / (uint32_t)hardware_holder.ticks_hz;
    for (; stepped + every <= now; stepped += every) {
        now_s = (double)stepped / hardware_clock_hz;
        if (stepping) board_holder_tick();
    }
    now_s = (double)now / hardware_clock_hz;
}

static void hear(const char *word) {
    if (word[0] == 'h') board_hung_up();
    else if (word[0] == 'b') blocked = true;
    else contact_is_open = word[0] == 'o';
}
#else
#define step_until(now) (void)(now_s = (double)(now) / hardware_clock_hz)
#define hear(word) (void)(word)
#endif

void hardware_wait(void) {
    struct pollfd input = {STDIN_FILENO, POLLIN, 0};
    char word[80];
    poll(&input, 1, 1);
    if (input.revents) {
        if (read(STDIN_FILENO, word, sizeof word) <= 0) exit(0);
        hear(word);
    }
    while (sampling) {
        uint64_t due = (uint64_t)ticks * sampling_period + paused;
        if (ticks == pause_first && paused == 0) due += paused = (uint64_t)(pause_s * hardware_clock_hz);
        if (hardware_ticks() - sampling_since < due) break;
        step_until(sampling_since + due);
        take_sample(BOARD_HOLDER ? now_s : (double)due / hardware_clock_hz - rest_s, ticks, sampling_since + due);
        ticks++;
    }
    step_until(hardware_ticks());
}

static void open_port(void) {
    struct termios raw;
    int far_end;
    port = posix_openpt(O_RDWR | O_NOCTTY);
    if (port < 0 || grantpt(port) || unlockpt(port)) {
        perror("no pseudo-terminal");
        exit(3);
    }
    far_end = open(ptsname(port), O_RDWR | O_NOCTTY); /* kept open: the port outlives whoever uses it */
    tcgetattr(far_end, &raw);
    raw.c_iflag = raw.c_lflag = 0;
    raw.c_oflag = 0;
    raw.c_cflag = CS8 | CREAD | CLOCAL;
    tcsetattr(far_end, TCSANOW, &raw);
    fcntl(port, F_SETFL, O_NONBLOCK);
    printf("port: %s\n", ptsname(port));
    fflush(stdout);
}

void hardware_begin(int count, char **arguments) {
    int i;
    for (i = 1; i < count; i++) {
        if (!strcmp(arguments[i], "--speed") && i + 1 < count) speed = atof(arguments[++i]);
        else if (!strcmp(arguments[i], "--rest") && i + 1 < count) rest_s = atof(arguments[++i]);
        else if (!strcmp(arguments[i], "--sensor-fault") && i + 2 < count) {
            fault_first = (uint32_t)atol(arguments[++i]);
            fault_count = (uint32_t)atol(arguments[++i]);
        } else if (!strcmp(arguments[i], "--pause") && i + 2 < count) {
            pause_first = (uint32_t)atol(arguments[++i]);
            pause_s = atof(arguments[++i]);
        } else {
            fprintf(stderr, "hardware_host [--speed X] [--rest SECONDS] [--sensor-fault FIRST COUNT]"
                            " [--pause FIRST SECONDS]\n");
            exit(2);
        }
    }
    began = seconds();
    open_port();
}
