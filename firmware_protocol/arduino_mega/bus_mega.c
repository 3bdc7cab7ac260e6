/* The buses of an Arduino for accelerometers with a digital output: SPI for the ADXL355, I2C for the MPU-6050. */
#include <avr/io.h>

#include "rig.h"

#if ACCELERATION == ADXL355

#ifdef __AVR_ATmega2560__ /* pins 53 SS, 52 SCK, 51 MOSI, 50 MISO */
#define SELECT PB0
#define CLOCK PB1
#define OUT PB2
#else /* pins 10, 13, 11, 12 */
#define SELECT PB2
#define CLOCK PB5
#define OUT PB3
#endif

static uint8_t exchange(uint8_t byte) {
    SPDR = byte;
    while (!(SPSR & _BV(SPIF))) {
    }
    return SPDR;
}

static void select_sensor(uint8_t command) {
    PORTB |= _BV(SELECT);
    DDRB |= _BV(SELECT) | _BV(CLOCK) | _BV(OUT);
    SPCR = _BV(SPE) | _BV(MSTR); /* mode 0, a quarter of the clock: 4 MHz */
    PORTB &= (uint8_t)~_BV(SELECT);
    (void)exchange(command);
}

bool bus_read(uint8_t first_register, uint8_t *bytes, uint8_t count) {
    select_sensor((uint8_t)(first_register << 1 | 1));
    while (count--) *bytes++ = exchange(0);
    PORTB |= _BV(SELECT);
    return true; /* SPI has no acknowledgement: adxl355_begin() reads the identity */
}

bool bus_write(uint8_t register_, uint8_t byte) {
    select_sensor((uint8_t)(register_ << 1));
    (void)exchange(byte);
    PORTB |= _BV(SELECT);
    return true;
}

#elif ACCELERATION == MPU6050

#define ADDRESS 0x68
#define START_SENT 0x08
#define REPEATED_START_SENT 0x10
#define ADDRESS_TO_WRITE_ANSWERED 0x18
#define BYTE_ANSWERED 0x28
#define ADDRESS_TO_READ_ANSWERED 0x40

/* Do one step on the bus and return its status; 0 when it does not end within half a millisecond. */
static uint8_t step(uint8_t control) {
    uint16_t patience = 800;
    TWCR = _BV(TWINT) | _BV(TWEN) | control;
    while (!(TWCR & _BV(TWINT)))
        if (--patience == 0) return 0;
    return TWSR & 0xF8;
}

static bool send(uint8_t byte) {
    uint8_t status;
    TWDR = byte;
    status = step(0);
    return status == ADDRESS_TO_WRITE_ANSWERED || status == ADDRESS_TO_READ_ANSWERED || status == BYTE_ANSWERED;
}

/* Let go of the bus, whatever state it is in. */
static bool end(bool good) {
    uint16_t patience = 800;
    TWCR = _BV(TWINT) | _BV(TWEN) | _BV(TWSTO);
    while ((TWCR & _BV(TWSTO)) && --patience) {
    }
    if (!good) TWCR = 0;
    return good;
}

static bool begin(uint8_t register_) {
    uint8_t status;
    TWSR = 0;
    TWBR = (CLOCK_HZ / 400000 - 16) / 2;
    status = step(_BV(TWSTA));
    return (status == START_SENT || status == REPEATED_START_SENT) && send(ADDRESS << 1) && send(register_);
}

bool bus_read(uint8_t first_register, uint8_t *bytes, uint8_t count) {
    if (!begin(first_register) || step(_BV(TWSTA)) != REPEATED_START_SENT || !send(ADDRESS << 1 | 1))
        return end(false);
    while (count--) {
        if (!step(count ? _BV(TWEA) : 0)) return end(false);
        *bytes++ = TWDR;
    }
    return end(true);
}

bool bus_write(uint8_t register_, uint8_t byte) { return end(begin(register_) && send(byte)); }

#else
typedef char no_bus_is_needed;
#endif
