/* The hardware layer for an Arduino Mega 2560 (also Uno and Nano: ATmega328P): registers only, no Arduino library.
 *
 * Timer 1 runs free at the processor's clock and times everything. Its compare interrupt begins a sample: the
 * converter's readings, in the order 0 1 1 0 0 1 ..., so that both channels have the same mean instant. The
 * last reading's interrupt gives the sample to board_sample(). A sample that is not finished at the next tick counts
 * as missed.
 */
#define CONVERTER_BITS 10
#include "src/hardware.h"
#include "rig.h"
#include "src/rig_channels.h"

#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

#if READINGS < 2 || READINGS > 16 || (READINGS & (READINGS - 1))
#error "READINGS in rig.h: 2, 4, 8 or 16"
#endif
#define ANALOG_CHANNELS (ACCELERATION == ADXL335 ? 2 : 1)
#define READING_CYCLES (13UL * 128UL)

#ifndef USART0_RX_vect /* the ATmega328P has one port only, without a number */
#define USART0_RX_vect USART_RX_vect
#define USART0_UDRE_vect USART_UDRE_vect
#endif

const char hardware_firmware[] = "free-decay board 1.0";
#ifdef __AVR_ATmega2560__
const char hardware_board[] = "Arduino Mega 2560";
#else
const char hardware_board[] = "Arduino with ATmega328P";
#endif
const uint32_t hardware_clock_hz = CLOCK_HZ;
const wire_real hardware_clock_error_ppm = CLOCK_ERROR_PPM;

static uint32_t boot_id;
static uint8_t reset_cause;

/* ---- The clock: 48 bits, of which timer 1 has the lower 16 ---- */

static volatile uint32_t wraps;

ISR(TIMER1_OVF_vect) { wraps++; }

uint64_t hardware_ticks(void) {
    uint32_t upper;
    uint16_t lower;
    uint8_t state = SREG;
    cli();
    upper = wraps;
    lower = TCNT1;
    if ((TIFR1 & _BV(TOV1)) && lower < 0x8000) upper++;
    SREG = state;
    return (uint64_t)upper << 16 | lower;
}

/* ---- The samples ---- */

static struct {
    uint16_t part, last_part; /* a period longer than the timer is waited for in parts */
    uint8_t parts, parts_left;
    uint8_t readings; /* of each channel in one sample */
    uint8_t shift;    /* that makes fewer readings the same number */
} plan;

static uint16_t first_part(void) { return plan.parts == 1 ? plan.last_part : plan.part; }

static volatile bool converting;
static uint32_t taken_at; /* by the clock, less what the interrupt was late: a tick that was missed shows */
static uint8_t reading;
static uint16_t sum[2];
#if ACCELERATION != ADXL335
static int16_t digital;
static bool digital_answers;
#endif

static void begin_reading(void) {
    uint8_t second = ANALOG_CHANNELS == 2 && ((reading + 1) & 2);
    ADMUX = second ? ACCELERATION_PIN : DISPLACEMENT_PIN; /* reference: the AREF pin */
    ADCSRA |= _BV(ADSC);
}

static void begin_sample(uint32_t now) {
    if (converting) board_sample(0, taken_at);
    reading = 0;
    sum[0] = sum[1] = 0;
    converting = true;
    taken_at = now;
    begin_reading();
#if ACCELERATION != ADXL335
    digital_answers = acceleration_read(&digital);
#endif
}

static void end_sample(void) {
    int16_t numbers[BOARD_CHANNELS];
    converting = false;
    numbers[0] = (int16_t)((sum[0] << plan.shift) - 8192u);
#if ACCELERATION == ADXL335
    numbers[1] = (int16_t)((sum[1] << plan.shift) - 8192u);
    board_sample(numbers, taken_at);
#else
    numbers[1] = digital;
    board_sample(digital_answers ? numbers : 0, taken_at);
#endif
}

ISR(TIMER1_COMPA_vect) {
    uint16_t late = TCNT1 - OCR1A;
    if (--plan.parts_left > 0) {
        OCR1A += plan.parts_left == 1 ? plan.last_part : plan.part;
        return;
    }
    plan.parts_left = plan.parts;
    OCR1A += first_part();
    begin_sample((uint32_t)hardware_ticks() - late);
    board_late(late);
}

ISR(ADC_vect) {
    uint16_t value = ADC;
    if (!converting) return;
    sum[ANALOG_CHANNELS == 2 && ((reading + 1) & 2)] += value;
    if (++reading < plan.readings * ANALOG_CHANNELS) begin_reading();
    else end_sample();
}

/* 7 Hz to 2 kHz: what two readings of each channel leave room for. */
uint32_t hardware_period(wire_real asked_hz) {
    if (asked_hz == 0) asked_hz = 256;
    return asked_hz >= 7 && asked_hz <= 2000 ? (uint32_t)((wire_real)CLOCK_HZ / asked_hz + (wire_real)0.5) : 0;
}

static void make_plan(uint32_t period) {
    plan.parts = plan.parts_left = (uint8_t)((period >> 16) + 1);
    plan.part = (uint16_t)(period / plan.parts);
    plan.last_part = (uint16_t)(period - (uint32_t)plan.part * (plan.parts - 1u));
    plan.readings = READINGS;
    while (plan.readings > 2 && plan.readings * ANALOG_CHANNELS * (READING_CYCLES + 100) > period) plan.readings /= 2;
    plan.shift = 0;
    while ((uint8_t)(plan.readings << plan.shift) < 16) plan.shift++;
}

bool hardware_start_sampling(uint32_t period, uint64_t *first) {
    make_plan(period);
    if (!acceleration_begin()) return false;
    cli();
    converting = false;
    *first = hardware_ticks() + period;
    OCR1A = (uint16_t)(*first - period + first_part());
    TIFR1 = _BV(OCF1A);
    TIMSK1 |= _BV(OCIE1A);
    sei();
    return true;
}

void hardware_stop_sampling(void) {
    cli();
    TIMSK1 &= (uint8_t)~_BV(OCIE1A);
    converting = false;
    sei();
}

#if BOARD_HOLDER
/* ---- The holder: pins 22 to 26, a step a tick of timer 3 ---- */

#ifndef __AVR_ATmega2560__
#error "a holder needs an ATmega2560: the ATmega328P has no memory left"
#endif
#define STEP _BV(PA0)      /* 22, to the driver's STEP */
#define DIRECTION _BV(PA1) /* 23, to its DIR: high is outward */
#define MAGNET _BV(PA2)    /* 24, to the transistor's gate, with 10 kOhm to ground: off without a program */
#define END _BV(PA3)       /* 25, end switch to ground: closes at the end */
#define CONTACT _BV(PA4)   /* 26, stop contact to ground: closed unless pressed, or broken */

ISR(TIMER3_COMPA_vect) { board_holder_tick(); }

static void begin_holder(void) {
    PORTA = END | CONTACT;
    DDRA = STEP | DIRECTION | MAGNET;
    TCCR3B = _BV(WGM32) | _BV(CS31);
    OCR3A = (uint16_t)(CLOCK_HZ / 8 / HOLDER_STEPS_HZ - 1);
}

void hardware_holder_clock(bool runs) {
    if (runs) TIMSK3 |= _BV(OCIE3A);
    else TIMSK3 = 0;
}

void hardware_holder_step(bool outward) {
    if (outward) PORTA |= DIRECTION;
    else PORTA &= (uint8_t)~DIRECTION;
    PORTA |= STEP;
    __builtin_avr_delay_cycles(32); /* 2 us */
    PORTA &= (uint8_t)~STEP;
}

void hardware_holder_magnet(bool on) {
    if (on) PORTA |= MAGNET;
    else PORTA &= (uint8_t)~MAGNET;
}

bool hardware_holder_at_end(void) { return !(PINA & END); }
bool hardware_stop_contact_is_open(void) { return PINA & CONTACT; }
#endif

/* ---- The port: UART 0, which is the Mega's USB connector ---- */

#define RECEIVED (RAMEND > 0x1000 ? 128 : 64) /* powers of two */
#define SENDING 64

static volatile uint8_t received[RECEIVED], sending[SENDING];
static volatile uint8_t received_head, received_tail, sending_head, sending_tail;

ISR(USART0_RX_vect) {
    uint8_t byte = UDR0, next = (received_head + 1) % RECEIVED;
    if (next == received_tail) return; /* full: the frame's checksum will tell */
    received[received_head] = byte;
    received_head = next;
}

ISR(USART0_UDRE_vect) {
    if (sending_tail == sending_head) {
        UCSR0B &= (uint8_t)~_BV(UDRIE0);
        return;
    }
    UDR0 = sending[sending_tail];
    sending_tail = (sending_tail + 1) % SENDING;
}

size_t hardware_receive(uint8_t *bytes, size_t room) {
    size_t count = 0;
    while (count < room && received_tail != received_head) {
        bytes[count++] = received[received_tail];
        received_tail = (received_tail + 1) % RECEIVED;
    }
    return count;
}

size_t hardware_send(const uint8_t *bytes, size_t count) {
    size_t taken = 0;
    uint8_t next;
    while (taken < count && (next = (sending_head + 1) % SENDING) != sending_tail) {
        sending[sending_head] = bytes[taken++];
        sending_head = next;
    }
    cli();
    UCSR0B |= _BV(UDRIE0);
    sei();
    return taken;
}

/* ---- Identity ---- */

static uint16_t read_once(uint8_t pin) {
    ADMUX = pin; /* by the AREF pin: another reference would be short-circuited with it */
    ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);
    while (ADCSRA & _BV(ADSC)) {
    }
    return ADC;
}

/* The boots are counted in the last four bytes of the EEPROM; an open input adds noise, for two boards that have
 * been reset as often. */
static uint32_t new_boot_id(void) {
    uint32_t *place = (uint32_t *)(uintptr_t)(E2END - 3);
    uint32_t boots = eeprom_read_dword(place) + 1, hash = 2166136261u ^ boots;
    uint8_t i;
    eeprom_write_dword(place, boots);
    for (i = 0; i < 32; i++) hash = (hash ^ read_once(7)) * 16777619u;
    return hash ^ boots;
}

uint32_t hardware_boot_id(void) { return boot_id; }
uint8_t hardware_reset_cause(void) { return reset_cause; }
const char *hardware_unique_id(void) { return UNIQUE_ID; }

static uint8_t cause_of(uint8_t flags) {
    if (flags & _BV(WDRF)) return WIRE_RESET_WATCHDOG;
    if (flags & _BV(PORF)) return WIRE_RESET_POWER_ON;
    if (flags & _BV(BORF)) return WIRE_RESET_BROWNOUT;
    if (flags & _BV(EXTRF)) return WIRE_RESET_PIN;
    return WIRE_RESET_OTHER; /* the boot loader has cleared the flags */
}

void hardware_begin(int count, char **arguments) {
    (void)count;
    (void)arguments;
    cli();
    reset_cause = cause_of(MCUSR);
    MCUSR = 0;
    boot_id = new_boot_id();
    ADCSRA = _BV(ADEN) | _BV(ADIE) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0); /* 125 kHz: all 10 bits */
    DIDR0 = 0xFF;
    TCCR1A = 0;
    TCCR1B = _BV(CS10);
    TIMSK1 = _BV(TOIE1);
    UCSR0A = _BV(U2X0);
    UBRR0 = (CLOCK_HZ / 8 + BAUD / 2) / BAUD - 1;
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0);
#if BOARD_HOLDER
    begin_holder();
#endif
    set_sleep_mode(SLEEP_MODE_IDLE);
    sei();
}

/* Any interrupt wakes; timer 1 wraps every 4 ms. */
void hardware_wait(void) { sleep_mode(); }
