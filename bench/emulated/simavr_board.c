/* An Arduino in simavr: the image runs instruction by instruction, its UART is a pseudo-terminal, its converter sees
 * the voltages of a file.
 *
 *   simavr_board IMAGE MCU --volts FILE --file-hz HZ [--reference-mv MV] [--noise-mv MV] [--speed X] [--seed N]
 *                [--at "SECONDS COMMAND"] [--sensor ADXL355|MPU6050] [--boot-loader HEX] [--holder REST_S]
 *
 * FILE holds pairs of 32-bit floats, volts at pins A0 and A1, HZ pairs a second. Its time begins anew when the
 * converter begins to read them after half a second of rest; behind its end the last voltages stay. At each conversion
 * the voltage is taken at the very cycle, with noise.
 * With --holder a carriage stands 3 mm from its end switch, and the mass rests in the middle until the magnet grips it;
 * when it is let go outside, FILE is read from REST_S on.
 * Commands on standard input, one a line, or one at a time of the file: `reset`; `lose N`, the next N bytes to the
 * host are lost; `open`, the stop contact; `die`. It ends when standard input is closed, and then says on standard output what it has measured.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <simavr/avr_adc.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_spi.h>
#include <simavr/avr_twi.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_hex.h>
#include <simavr/sim_io.h>
#include <simavr/sim_irq.h>

static avr_t *avr;
static float *volts;
static size_t pairs;
static double file_hz = 16384, noise_mv, speed = 1, at_s;
static const char *at_command;
static uint64_t motion_since, last_conversion, conversions;
static uint64_t random_state = 88172645463325252ull;
static int port = -1, to_lose, xon = 1;
static uint8_t out[1 << 16], in[1 << 16];
static size_t out_count, in_count, in_at;
static uint64_t bytes_sent, slept, least_stack = ~0ull;

static double uniform(void) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (double)(random_state >> 11) / 9007199254740992.0;
}

static double normal(void) {
    double sum = -6;
    int i;
    for (i = 0; i < 12; i++) sum += uniform();
    return sum;
}

/* ---- The holder: pins PA0 to PA4, steps of 10 um ---- */

static double holder_rest_s = -1;
static int carriage = 2700, outward;
static enum { AT_REST, GRIPPED, SWINGS } mass = AT_REST;

/* Against the pull-up, which simavr puts on the pin again at each write to the port. */
static void holder_input(int pin, uint32_t level) {
    static avr_ioport_external_t outside = {.name = 'A', .mask = 1 << 3 | 1 << 4};
    outside.value = (outside.value & ~(1u << pin)) | level << pin;
    avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL('A'), &outside);
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('A'), pin), level);
}

static void on_step(avr_irq_t *irq, uint32_t level, void *unused) {
    (void)irq;
    (void)unused;
    if (!level) return;
    carriage += outward ? 1 : -1;
    holder_input(3, carriage < 3000);
}

static void on_direction(avr_irq_t *irq, uint32_t level, void *unused) {
    (void)irq;
    (void)unused;
    outward = level != 0;
}

static void on_magnet(avr_irq_t *irq, uint32_t level, void *unused) {
    (void)irq;
    (void)unused;
    if (level) {
        mass = GRIPPED;
    } else if (mass == GRIPPED) {
        mass = carriage > 100 ? SWINGS : AT_REST;
        motion_since = avr->cycle - (uint64_t)(holder_rest_s * avr->frequency);
    }
}

static void add_holder(void) {
    avr_irq_t *pins = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('A'), 0);
    if (holder_rest_s < 0) return;
    avr_irq_register_notify(pins, on_step, NULL);
    avr_irq_register_notify(pins + 1, on_direction, NULL);
    avr_irq_register_notify(pins + 2, on_magnet, NULL);
    holder_input(3, 1);
    holder_input(4, 0);
}

/* ---- Converter ---- */

static double volts_at(uint64_t cycle, int pin) {
    double at = (double)(cycle - motion_since) / avr->frequency * file_hz;
    size_t index = (size_t)at;
    double part = at - (double)index;
    if (pairs == 0) return 0;
    if (holder_rest_s >= 0 && mass != SWINGS)
        return 1.65 + (pin == 0 && mass == GRIPPED ? carriage * 1e-5 / 0.015152 : 0);
    if (index + 1 >= pairs) return volts[2 * (pairs - 1) + pin];
    return volts[2 * index + pin] * (1 - part) + volts[2 * index + 2 + pin] * part;
}

static void on_conversion(avr_irq_t *irq, uint32_t value, void *unused) {
    avr_adc_mux_t mux;
    double mv;
    (void)irq;
    (void)unused;
    memcpy(&mux, &value, sizeof value); /* the kind and the pin stand in the first four bytes */
    if (mux.src < 2) {
        if (holder_rest_s < 0 && (conversions == 0 || avr->cycle - last_conversion > avr->frequency / 2)) motion_since = avr->cycle;
        last_conversion = avr->cycle;
        conversions++;
    }
    /* simavr divides the reference into 1023 steps, the converter into 1024. */
    mv = mux.src < 2 ? (volts_at(avr->cycle, mux.src) * 1000 + noise_mv * normal()) * 1024 / 1023 : 400 * uniform();
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + mux.src), mv > 0 ? (uint32_t)(mv + 0.5) : 0);
}

/* ---- Digital accelerometers: registers behind SPI (ADXL355) and I2C (MPU-6050), data at the very cycle ---- */

static uint8_t spi_selected, spi_count, spi_register, twi_selected, twi_count, twi_register;
static uint8_t adxl_settings[128], mpu_settings[128];

static double gravities(void) { return (volts_at(avr->cycle, 1) - 1.65) / 0.330; }

static int32_t adxl_latched; /* for one transfer */

static uint8_t adxl355(uint8_t address) {
    int32_t counts = adxl_latched * 16; /* 20 bits, left in 24 */
    if (address == 0x00) return 0xAD;
    if (address == 0x01) return 0x1D;
    if (adxl_settings[0x2D] & 1 || adxl_settings[0x2C] % 4 != 1) return 0; /* standby; another range */
    return address >= 0x08 && address <= 0x0A ? (uint8_t)(counts >> 8 * (0x0A - address)) : 0;
}

static uint8_t mpu6050(uint8_t address) {
    int16_t counts = (int16_t)floor(gravities() * 16384 + 0.5);
    if (address == 0x75) return 0x68;
    if (mpu_settings[0x6B] & 0x40) return 0; /* asleep */
    return address == 0x3B ? (uint8_t)(counts >> 8) : address == 0x3C ? (uint8_t)counts : 0;
}

static void on_select(avr_irq_t *irq, uint32_t level, void *unused) {
    (void)irq;
    (void)unused;
    spi_selected = !level;
    spi_count = 0;
}

static void on_spi(avr_irq_t *irq, uint32_t value, void *unused) {
    uint8_t answer = 0;
    (void)irq;
    (void)unused;
    if (!spi_selected) return;
    if (spi_count++ == 0) {
        spi_register = (uint8_t)value;
        adxl_latched = (int32_t)floor(gravities() * 256000 + 0.5);
    } else if (spi_register & 1) answer = adxl355((uint8_t)((spi_register >> 1) + spi_count - 2));
    else adxl_settings[(spi_register >> 1) + spi_count - 2] = (uint8_t)value;
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_SPI_GETIRQ(0), SPI_IRQ_INPUT), answer);
}

static void answer_twi(uint8_t message, uint8_t data) {
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_INPUT),
                  avr_twi_irq_msg(message, twi_selected, data));
}

static void on_twi(avr_irq_t *irq, uint32_t value, void *unused) {
    avr_twi_msg_irq_t message;
    (void)irq;
    (void)unused;
    message.u.v = value;
    if (message.u.twi.msg & TWI_COND_STOP) twi_selected = 0;
    if (message.u.twi.msg & TWI_COND_START) {
        twi_selected = message.u.twi.addr >> 1 == 0x68 ? message.u.twi.addr : 0;
        twi_count = 0;
        if (twi_selected) answer_twi(TWI_COND_ACK, 1);
    }
    if (!twi_selected) return;
    if (message.u.twi.msg & TWI_COND_WRITE) {
        answer_twi(TWI_COND_ACK, 1);
        if (twi_count++ == 0) twi_register = message.u.twi.data;
        else mpu_settings[twi_register++ & 127] = message.u.twi.data;
    }
    if (message.u.twi.msg & TWI_COND_READ) answer_twi(TWI_COND_READ, mpu6050(twi_register++));
}

/* simavr 1.6 leaves the flag standing that a program clears by writing it, so that whoever polls it does not wait. */
static void on_twi_control(avr_t *which, avr_io_addr_t address, uint8_t value, void *unused) {
    (void)unused;
    if (value & 0x80) which->data[address] &= 0x7F;
}

static void plug_in(const char *sensor) {
    adxl_settings[0x2D] = 1;
    mpu_settings[0x6B] = 0x40;
    if (!strcmp(sensor, "ADXL355")) {
        avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_SPI_GETIRQ(0), SPI_IRQ_OUTPUT), on_spi, NULL);
        avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), 0), on_select, NULL);
    } else if (!strcmp(sensor, "MPU6050")) {
        avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_OUTPUT), on_twi, NULL);
        avr_register_io_write(avr, 0xBC, on_twi_control, avr);
    }
}

/* ---- UART ---- */

static void on_byte(avr_irq_t *irq, uint32_t value, void *unused) {
    (void)irq;
    (void)unused;
    bytes_sent++;
    if (to_lose > 0) to_lose--;
    else if (out_count < sizeof out) out[out_count++] = (uint8_t)value;
}

static void on_xon(avr_irq_t *irq, uint32_t value, void *on) {
    (void)irq;
    (void)value;
    xon = on != NULL;
}

static void move_bytes(void) {
    ssize_t count;
    if (out_count && (count = write(port, out, out_count)) > 0) {
        memmove(out, out + count, out_count - (size_t)count);
        out_count -= (size_t)count;
    }
    if (in_at == in_count) {
        in_at = 0;
        count = read(port, in, sizeof in);
        in_count = count > 0 ? (size_t)count : 0;
    }
    while (xon && in_at < in_count) avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT), in[in_at++]);
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
    cfmakeraw(&raw);
    tcsetattr(far_end, TCSANOW, &raw);
    fcntl(port, F_SETFL, O_NONBLOCK);
    printf("port: %s\n", ptsname(port));
    fflush(stdout);
}

/* ---- Time and commands ---- */

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void on_sleep(avr_t *which, avr_cycle_count_t cycles) {
    (void)which;
    slept += cycles;
}

static void report(void) {
    printf("{\"cycles\": %llu, \"slept\": %llu, \"bytes_sent\": %llu, \"stack_bytes\": %llu}\n",
           (unsigned long long)avr->cycle, (unsigned long long)slept, (unsigned long long)bytes_sent,
           (unsigned long long)(avr->ramend - least_stack));
    fflush(stdout);
}

static void command(const char *line) {
    if (!strcmp(line, "reset")) avr_reset(avr);
    else if (!strcmp(line, "open")) holder_input(4, 1);
    else if (!strcmp(line, "die")) exit(0);
    else if (sscanf(line, "lose %d", &to_lose) != 1) fprintf(stderr, "no such command: %s\n", line);
}

static void obey(void) {
    static char line[256];
    static size_t length;
    struct pollfd input = {STDIN_FILENO, POLLIN, 0};
    char byte;
    while (poll(&input, 1, 0) > 0) {
        if (read(STDIN_FILENO, &byte, 1) <= 0) {
            report();
            exit(0);
        }
        if (byte != '\n') {
            if (length + 1 < sizeof line) line[length++] = byte;
            continue;
        }
        line[length] = 0;
        length = 0;
        command(line);
    }
    if (conversions && at_command && avr->cycle - motion_since > at_s * avr->frequency) {
        command(at_command);
        at_command = NULL;
    }
}

/* Run the image as far as the computer's clock has gone, a millisecond at a time. */
static void run(void) {
    double began = seconds();
    for (;;) {
        double ahead;
        avr_cycle_count_t until = avr->cycle + avr->frequency / 1000;
        while (avr->cycle < until) {
            int state = avr_run(avr);
            uint64_t stack = (uint64_t)avr->data[R_SPL] | (uint64_t)avr->data[R_SPH] << 8;
            if (stack > 0x200 && stack < least_stack) least_stack = stack;
            if (state == cpu_Done || state == cpu_Crashed) {
                fprintf(stderr, "the image has crashed\n");
                exit(1);
            }
        }
        move_bytes();
        obey();
        ahead = (double)avr->cycle / avr->frequency / speed - (seconds() - began);
        if (ahead > 0) usleep((useconds_t)(ahead * 1e6));
    }
}

/* A reset leads into the boot loader at the end of the flash, as on a board from the shop. */
static void boot_by(const char *path) {
    uint32_t size = 0, base = 0;
    uint8_t *bytes = read_ihex_file(path, &size, &base);
    if (!bytes || base + size > avr->flashend + 1) exit(2);
    memcpy(avr->flash + base, bytes, size);
    avr->codeend = avr->flashend;
    avr->pc = avr->reset_pc = base;
}

static void read_volts(const char *path) {
    FILE *file = fopen(path, "rb");
    long size;
    if (!file) {
        perror(path);
        exit(2);
    }
    fseek(file, 0, SEEK_END);
    size = ftell(file);
    rewind(file);
    volts = malloc((size_t)size);
    pairs = (size_t)size / (2 * sizeof *volts);
    if (fread(volts, 2 * sizeof *volts, pairs, file) != pairs) exit(2);
    fclose(file);
}

int main(int count, char **arguments) {
    elf_firmware_t image;
    uint32_t flags = 0, reference_mv = 3300;
    const char *sensor = "", *boot_loader = NULL;
    int i;
    if (count < 3) return 2;
    for (i = 3; i + 1 < count; i += 2) {
        const char *name = arguments[i], *value = arguments[i + 1];
        if (!strcmp(name, "--volts")) read_volts(value);
        else if (!strcmp(name, "--file-hz")) file_hz = atof(value);
        else if (!strcmp(name, "--noise-mv")) noise_mv = atof(value);
        else if (!strcmp(name, "--speed")) speed = atof(value);
        else if (!strcmp(name, "--seed")) random_state ^= (uint64_t)atoll(value) * 0x9E3779B97F4A7C15ull;
        else if (!strcmp(name, "--sensor")) sensor = value;
        else if (!strcmp(name, "--holder")) holder_rest_s = atof(value);
        else if (!strcmp(name, "--boot-loader")) boot_loader = value;
        else if (!strcmp(name, "--reference-mv")) reference_mv = (uint32_t)atoi(value);
        else if (!strcmp(name, "--at") && strchr(value, ' ')) {
            at_s = atof(value);
            at_command = strchr(value, ' ') + 1;
        } else return 2;
    }
    memset(&image, 0, sizeof image);
    if (elf_read_firmware(arguments[1], &image)) return 2;
    avr = avr_make_mcu_by_name(arguments[2]);
    if (!avr) return 2;
    avr_init(avr);
    image.frequency = 16000000;
    avr_load_firmware(avr, &image);
    avr->frequency = 16000000;
    avr->vcc = avr->avcc = 5000;
    avr->aref = reference_mv;
    avr->sleep = on_sleep;
    avr->log = LOG_ERROR;
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(uint32_t)(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POOL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER), on_conversion, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_byte, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), on_xon, &xon);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), on_xon, NULL);
    plug_in(sensor);
    add_holder();
    if (boot_loader) boot_by(boot_loader);
    open_port();
    run();
    return 0;
}
