/* The hardware layer for TI's EK-TM4C123GXL LaunchPad, and for the LM3S6965 evaluation board that QEMU emulates.
 *
 * Timer 0 triggers the converter in hardware: eight readings in the order 0 1 1 0 0 1 1 0, each the mean of 16, so that
 * both channels have the same mean instant and no interrupt can make a sample late. The converter's interrupt gives
 * the sample to board_sample(). The two chips differ in the crystal, the pins' switches and the converter's bits.
 */
#include "hardware.h"
#include "registers.h"
#include "rig.h"

#ifdef EMULATED
#include "emulated.h"
#else
#define TICKS_ADDED_BY_RELOADING 1
#endif

#ifdef BOARD_LM3S6965 /* 8 MHz crystal, converter of 10 bits */
#define CRYSTAL 0x0Eu
const char hardware_board[] = "LM3S6965 evaluation board";
#else /* 16 MHz, 12 bits */
#define CRYSTAL 0x15u
const char hardware_board[] = "EK-TM4C123GXL";
#endif
#if defined(BOARD_LM3S6965) && !defined(EMULATED)
#define CONVERTER_BITS 10
#else
#define CONVERTER_BITS 12
#endif
#include "rig_channels.h"

#define READINGS 8

const char hardware_firmware[] = "free-decay board 1.0";
const uint32_t hardware_clock_hz = CLOCK_HZ;
const wire_real hardware_clock_error_ppm = CLOCK_ERROR_PPM;

static uint32_t boot_id;

/* ---- The clock: the core's timer, and its turns counted by interrupt ---- */

#define TURN (CLOCK_HZ / 10u)

static volatile uint32_t turns;

void clock_interrupt(void) { turns++; }

/* Also called from the converter's interrupt, which may hold up the clock's: a turn that waits is counted. The timer
 * stands at 0 for one tick, in which the turn is not counted yet. 32 bits of turns last 13 years. */
uint64_t hardware_ticks(void) {
    uint32_t counted, waits, left;
    do {
        counted = turns;
        waits = SCB_ICSR & ICSR_CLOCK_PENDING;
        left = SYSTICK_VAL;
    } while (left == 0 || counted != turns || waits != (SCB_ICSR & ICSR_CLOCK_PENDING));
    return ((uint64_t)counted + (waits != 0)) * TURN + (TURN - left);
}

static void begin_clocks(void) {
    uint32_t rcc = SYSCTL_RCC;
    volatile uint32_t pause = 100000; /* for the crystal to start */
    rcc = (rcc | RCC_BYPASS) & ~RCC_USE_DIVIDER;
    SYSCTL_RCC = rcc;
    rcc = (rcc & ~((0x1Fu << 6) | (3u << 4) | 1u)) | CRYSTAL << 6; /* main oscillator on, and used */
    SYSCTL_RCC = rcc;
    while (pause--) {
    }
    rcc &= ~(RCC_PLL_OFF | 1u << 12);
    SYSCTL_RCC = rcc;
    rcc = (rcc & ~(0xFu << 23)) | 3u << 23 | RCC_USE_DIVIDER; /* 200 MHz / 4 */
    SYSCTL_RCC = rcc;
    while (!(SYSCTL_RIS & RIS_PLL_LOCKED)) {
    }
    SYSCTL_RCC = rcc & ~RCC_BYPASS;
    SYSTICK_LOAD = TURN - 1;
    SYSTICK_VAL = 0;
    SCB_SHPR3 = 0x40000000; /* below the converter */
    SYSTICK_CTRL = 7;
}

/* ---- The samples ---- */

static uint32_t period;
static volatile uint64_t due; /* when the sample being taken was triggered */

static int64_t ticks_since_due(void) { return (int64_t)(hardware_ticks() - due); }

#ifdef EMULATED
static bool converter_has_readings(void) { return ticks_since_due() >= -50; }
static bool read_converter(uint16_t readings[READINGS]) { return emulated_converter_read(readings); }
#else
static bool converter_has_readings(void) { return !(ADC0_SSFSTAT0 & FIFO_EMPTY); }

/* What the converter read at the oldest trigger that was not yet met, 12 bits each. */
static bool read_converter(uint16_t readings[READINGS]) {
    int i;
    for (i = 0; i < READINGS; i++) {
        if (ADC0_SSFSTAT0 & FIFO_EMPTY) return false;
        readings[i] = (uint16_t)(ADC0_SSFIFO0 << (12 - CONVERTER_BITS) & 0xFFF);
    }
    return true;
}
#endif

/* The timer triggered it at `at`, and samples that the converter lost are counted by the clock. */
static void take_sample(uint64_t at) {
    uint16_t readings[READINGS];
    int16_t numbers[BOARD_CHANNELS];
    bool complete = read_converter(readings);
    numbers[0] = (int16_t)(readings[0] + readings[3] + readings[4] + readings[7] - 8192);
#if ACCELERATION == ADXL335
    numbers[1] = (int16_t)(readings[1] + readings[2] + readings[5] + readings[6] - 8192);
#else
    complete &= acceleration_read(&numbers[1]);
#endif
    board_sample(complete ? numbers : 0, (uint32_t)at);
}

/* A trigger leaves its readings in the converter's FIFO; half a period later they are all there, or found it full. */
void converter_interrupt(void) {
    ADC0_ISC = 1;
    while (converter_has_readings()) {
        int64_t late = ticks_since_due();
        board_late((uint16_t)(late < 0 ? 0 : late < 0xFFFF ? late : 0xFFFF));
        take_sample(due);
        due += period;
    }
#ifndef EMULATED
    while (ticks_since_due() > (int64_t)(period / 2)) {
        board_sample(0, (uint32_t)due);
        due += period;
    }
#endif
}

/* 5 Hz to 2048 Hz. */
uint32_t hardware_period(wire_real asked_hz) {
    if (asked_hz == 0) asked_hz = 256;
    return asked_hz >= 5 && asked_hz <= 2048 ? (uint32_t)(CLOCK_HZ / asked_hz + 0.5) : 0;
}

bool hardware_start_sampling(uint32_t every, uint64_t *first) {
    if (!acceleration_begin()) return false;
#ifdef EMULATED
    if (!emulated_converter_begin()) return false;
#endif
    period = every;
#ifndef EMULATED
    while (!(ADC0_SSFSTAT0 & FIFO_EMPTY)) (void)ADC0_SSFIFO0;
#endif
    ADC0_ISC = 1;
    TIMER0_TAILR = period - TICKS_ADDED_BY_RELOADING;
    __asm__ volatile("cpsid i" ::: "memory");
    due = *first = hardware_ticks() + period;
    TIMER0_CTL = TIMER_RUNS | TIMER_TRIGGERS;
    __asm__ volatile("cpsie i" ::: "memory");
    ADC0_IM = 1;
    return true;
}

void hardware_stop_sampling(void) {
    TIMER0_CTL = 0;
    ADC0_IM = 0;
}

/* QEMU resets neither timer nor converter with the processor: nothing is taken to be as after power-on. */
static void begin_converter(void) {
    uint32_t x = DISPLACEMENT_INPUT;
#if ACCELERATION == ADXL335
    uint32_t a = ACCELERATION_INPUT;
#else
    uint32_t a = x;
#endif
    ADC0_ACTSS = 0;
    ADC0_SAC = 4; /* means of 16 */
    ADC0_SSMUX0 = x | a << 4 | a << 8 | x << 12 | x << 16 | a << 20 | a << 24 | x << 28;
    ADC0_SSCTL0 = 6u << 28; /* the eighth reading is the last, and interrupts */
    ADC0_EMUX = TRIGGER_BY_TIMER;
    ADC0_ACTSS = 1;
    TIMER0_CTL = 0;
    TIMER0_CFG = 0;
    TIMER0_TAMR = TIMER_PERIODIC;
}

#if BOARD_HOLDER
/* ---- The holder: pins PD0 to PD3 and PD6, a step a tick of timer 1 ---- */

#define STEP 1u      /* PD0, to the driver's STEP */
#define DIRECTION 2u /* PD1, to its DIR: high is outward */
#define MAGNET 4u    /* PD2, to the transistor's gate, with 10 kOhm to ground: off without a program */
#define END 8u       /* PD3, end switch to ground: closes at the end */
#define CONTACT 64u  /* PD6, stop contact to ground: closed unless pressed, or broken */

void holder_interrupt(void) {
    TIMER1_ICR = 1;
    board_holder_tick();
}

static void begin_holder(void) {
    SYSCTL_RCGC1 |= RCGC1_TIMER1;
    SYSCTL_RCGC2 |= RCGC2_GPIOD;
    (void)SYSCTL_RCGC2; /* three cycles until the registers can be reached */
    (void)SYSCTL_RCGC2;
    GPIO_DATA(GPIO_D, STEP | DIRECTION | MAGNET) = 0;
    GPIO_DIR(GPIO_D) |= STEP | DIRECTION | MAGNET;
    GPIO_PUR(GPIO_D) |= END | CONTACT;
    GPIO_DEN(GPIO_D) |= STEP | DIRECTION | MAGNET | END | CONTACT;
    TIMER1_CTL = 0;
    TIMER1_CFG = 0;
    TIMER1_TAMR = TIMER_PERIODIC;
    TIMER1_TAILR = CLOCK_HZ / HOLDER_STEPS_HZ - 1;
    TIMER1_IMR = 1;
    NVIC_IPR(IRQ_TIMER1A) = 0x60;
    NVIC_ISER0 = 1u << IRQ_TIMER1A;
}

void hardware_holder_clock(bool runs) { TIMER1_CTL = runs ? TIMER_RUNS : 0; }

void hardware_holder_step(bool outward) {
    volatile uint32_t pause = 25; /* 2 us or more */
    GPIO_DATA(GPIO_D, DIRECTION) = outward ? DIRECTION : 0;
    GPIO_DATA(GPIO_D, STEP) = STEP;
    while (pause--) {
    }
    GPIO_DATA(GPIO_D, STEP) = 0;
#ifdef EMULATED
    emulated_step(outward);
#endif
}

void hardware_holder_magnet(bool on) {
    GPIO_DATA(GPIO_D, MAGNET) = on ? MAGNET : 0;
#ifdef EMULATED
    emulated_magnet(on);
#endif
}

#ifdef EMULATED
bool hardware_holder_at_end(void) { return emulated_at_end(); }
bool hardware_stop_contact_is_open(void) { return false; }
#else
bool hardware_holder_at_end(void) { return !GPIO_DATA(GPIO_D, END); }
bool hardware_stop_contact_is_open(void) { return GPIO_DATA(GPIO_D, CONTACT) != 0; }
#endif
#endif

/* ---- The port: UART 0, which is the LaunchPad's USB connector ---- */

#define RECEIVED 256 /* a power of two */

static volatile uint8_t received[RECEIVED];
static volatile uint32_t received_head, received_tail;

void port_interrupt(void) {
    UART0_ICR = 0x7FF;
    while (!(UART0_FR & FR_RECEIVE_EMPTY)) {
        uint8_t byte = (uint8_t)UART0_DR;
        if (received_head - received_tail == RECEIVED) continue; /* full: the frame's checksum will tell */
        received[received_head % RECEIVED] = byte;
        received_head++;
    }
}

size_t hardware_receive(uint8_t *bytes, size_t room) {
    size_t count = 0;
    while (count < room && received_tail != received_head) bytes[count++] = received[received_tail++ % RECEIVED];
    return count;
}

/* Into the FIFO of 16 bytes; its interrupt wakes the main loop when most of them have gone. */
size_t hardware_send(const uint8_t *bytes, size_t count) {
    size_t taken = 0;
    while (taken < count && !(UART0_FR & FR_SEND_FULL)) UART0_DR = bytes[taken++];
    return taken;
}

static void begin_port(void) {
    uint32_t sixty_fourths = (CLOCK_HZ * 4u + BAUD / 2) / BAUD;
    UART0_CTL = 0;
    UART0_IBRD = sixty_fourths / 64;
    UART0_FBRD = sixty_fourths % 64;
    UART0_LCRH = 3u << 5 | 1u << 4; /* 8 bits, with FIFOs */
    UART0_IM = 7u << 4;             /* bytes came; bytes went; bytes came and then none */
    UART0_CTL = 0x301;
}

/* ---- Pins and identity ---- */

static void begin_pins(void) {
    SYSCTL_RCGC0 |= RCGC0_ADC0 | RCGC0_ADC_1_MSPS;
    SYSCTL_RCGC1 |= RCGC1_TIMER0 | RCGC1_UART0 | RCGC1_SSI0 | RCGC1_I2C0;
    SYSCTL_RCGC2 |= RCGC2_GPIOA | RCGC2_GPIOB | RCGC2_GPIOE;
    (void)SYSCTL_RCGC2; /* three cycles until the registers can be reached */
    (void)SYSCTL_RCGC2;
    GPIO_AFSEL(GPIO_A) |= 3;
    GPIO_DEN(GPIO_A) |= 3;
#ifndef BOARD_LM3S6965
    GPIO_PCTL(GPIO_A) |= 0x11;
    GPIO_AFSEL(GPIO_E) |= 0x0C; /* PE3 and PE2 */
    GPIO_DEN(GPIO_E) &= ~0x0Cu;
    GPIO_AMSEL(GPIO_E) |= 0x0C;
#endif
}

/* The noise in 64 readings of the chip's own thermometer. */
static uint32_t new_boot_id(void) {
    uint32_t hash = 2166136261u;
    int i;
    ADC0_ACTSS = 0;
    ADC0_EMUX = 0;
    ADC0_SSCTL0 = 0xEu; /* thermometer, interrupt, last */
    ADC0_ACTSS = 1;
    for (i = 0; i < 64; i++) {
        uint32_t patience = 1000;
        ADC0_PSSI = 1;
        while ((ADC0_SSFSTAT0 & FIFO_EMPTY) && --patience) {
        }
        hash = (hash ^ ADC0_SSFIFO0) * 16777619u;
    }
#ifdef EMULATED
    hash ^= emulated_chance();
#endif
    return hash;
}

uint32_t hardware_boot_id(void) { return boot_id; }
const char *hardware_unique_id(void) { return UNIQUE_ID; }

uint8_t hardware_reset_cause(void) {
    uint32_t causes = SYSCTL_RESC;
    if (causes & 1u << 3) return WIRE_RESET_WATCHDOG;
    if (causes & 1u << 4) return WIRE_RESET_SOFTWARE;
    if (causes & 1u << 1) return WIRE_RESET_POWER_ON;
    if (causes & 1u << 2) return WIRE_RESET_BROWNOUT;
    if (causes & 1u << 0) return WIRE_RESET_PIN;
    return WIRE_RESET_OTHER;
}

void hardware_begin(int count, char **arguments) {
    (void)count;
    (void)arguments;
    begin_clocks();
    begin_pins();
    begin_port();
    TIMER0_CTL = 0;
    boot_id = new_boot_id();
    begin_converter();
    ADC0_IM = 0;
    ADC0_ISC = 1;
    NVIC_ICPR0 = 1u << IRQ_UART0 | 1u << IRQ_ADC0_SS0;
    NVIC_IPR(IRQ_ADC0_SS0) = 0x00;
    NVIC_IPR(IRQ_UART0) = 0x20;
    NVIC_ISER0 = 1u << IRQ_UART0 | 1u << IRQ_ADC0_SS0;
#if BOARD_HOLDER
    begin_holder();
#endif
}

/* Any interrupt wakes; the clock's comes every 0.1 s. */
void hardware_wait(void) { __asm__ volatile("wfi"); }
