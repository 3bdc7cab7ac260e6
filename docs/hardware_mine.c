#include "hardware.h"

/* Your vendor's library. */
uint32_t TIMER_TICKS(void);
uint32_t TIMER_TICKS_AT_LAST_TICK(void);
uint32_t RANDOM_NUMBER(void);
int RESET_BY_WATCHDOG(void);
int PORT_READ(uint8_t *bytes, int room);
int PORT_WRITE(const uint8_t *bytes, int count);
void SETUP_CLOCKS_PORT_CONVERTER(void);
int SENSORS_ANSWER(void);
void TIMER_START(uint32_t every_ticks);
void TIMER_STOP(void);
int CONVERTER_READ(int16_t numbers[2]);
void SLEEP_UNTIL_INTERRUPT(void);

const char hardware_firmware[] = "my firmware 1.0";
const char hardware_board[] = "my board";
const uint32_t hardware_clock_hz = 48000000;
const wire_real hardware_clock_error_ppm = 30; /* of the crystal, over the temperatures of your bench */

#define TEXT(s) {s, sizeof s - 1}
const struct wire_channel hardware_channels[BOARD_CHANNELS] = {
    /* scale, offset, rate (filled in later), low, high, resolution, group delay, four texts */
    {1.094e-6, 0, 0, -0.025, 0.025, 1.094e-6, 0.0041, TEXT("x"), TEXT("displacement"), TEXT("m"),
     TEXT("LVDT 0815")},
    {1.496e-3, 0, 0, -29.4, 29.4, 1.496e-3, 0.0050, TEXT("a"), TEXT("acceleration"), TEXT("m/s^2"),
     TEXT("ADXL335 no. 3")},
};

void hardware_begin(int count, char **arguments) {
    (void)count;
    (void)arguments;
    SETUP_CLOCKS_PORT_CONVERTER();
}

void hardware_wait(void) { SLEEP_UNTIL_INTERRUPT(); }

/* Called in every step of the main loop, so the 32-bit timer (89 s) never wraps unseen. */
uint64_t hardware_ticks(void) {
    static uint32_t before, wraps;
    uint32_t now = TIMER_TICKS();
    if (now < before) wraps++;
    before = now;
    return (uint64_t)wraps << 32 | now;
}

uint32_t hardware_boot_id(void) { return RANDOM_NUMBER(); }
uint8_t hardware_reset_cause(void) {
    return RESET_BY_WATCHDOG() ? WIRE_RESET_WATCHDOG : WIRE_RESET_OTHER;
}
const char *hardware_unique_id(void) { return "0815"; }

/* From and into the buffers of your port's driver; never wait. */
size_t hardware_receive(uint8_t *bytes, size_t room) { return (size_t)PORT_READ(bytes, (int)room); }
size_t hardware_send(const uint8_t *bytes, size_t count) { return (size_t)PORT_WRITE(bytes, (int)count); }

/* This timer divides 48 MHz by a whole number; hardware_clock_hz / period is what it will really do. */
uint32_t hardware_period(wire_real asked_hz) {
    wire_real rate = asked_hz == 0 ? 256 : asked_hz;
    if (!(rate >= 5 && rate <= 256)) return 0;
    return (uint32_t)(hardware_clock_hz / rate + (wire_real)0.5);
}

bool hardware_start_sampling(uint32_t period, uint64_t *first) {
    if (!SENSORS_ANSWER()) return false;
    *first = hardware_ticks() + period;
    TIMER_START(period);
    return true;
}

void hardware_stop_sampling(void) { TIMER_STOP(); }

/* The timer's interrupt. */
void timer_interrupt(void) {
    int16_t numbers[BOARD_CHANNELS];
    board_late((uint16_t)(TIMER_TICKS() - TIMER_TICKS_AT_LAST_TICK()));
    board_sample(CONVERTER_READ(numbers) ? numbers : NULL, TIMER_TICKS());
}
