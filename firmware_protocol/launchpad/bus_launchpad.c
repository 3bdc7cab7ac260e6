/* The buses of the LaunchPad for accelerometers with a digital output: SPI for the ADXL355, I2C for the MPU-6050. */
#include "registers.h"
#include "rig.h"

#if ACCELERATION == ADXL355

/* Pins PA2 clock, PA4 from the sensor, PA5 to it; PA3 selects, by hand, since the port would let go between bytes. */
#define SELECT GPIO_DATA(GPIO_A, 1u << 3)
#define BUSY (1u << 4)

static bool transfer(uint8_t command, uint8_t write, uint8_t *read, uint8_t count) {
    uint8_t i;
    GPIO_AFSEL(GPIO_A) |= 0x34;
    GPIO_DEN(GPIO_A) |= 0x3C;
    GPIO_DIR(GPIO_A) |= 1u << 3;
#ifndef BOARD_LM3S6965
    GPIO_PCTL(GPIO_A) = (GPIO_PCTL(GPIO_A) & ~0xFF0F00u) | 0x220200;
#endif
    SSI0_CR1 = 0;
    SSI0_CPSR = 10; /* 5 MHz */
    SSI0_CR0 = 7;   /* mode 0, 8 bits */
    SSI0_CR1 = 2;
    SELECT = 0;
    for (i = 0; i <= count; i++) {
        uint8_t byte;
        SSI0_DR = i == 0 ? command : write;
        while (SSI0_SR & BUSY) {
        }
        byte = (uint8_t)SSI0_DR;
        if (read && i > 0) read[i - 1] = byte;
    }
    SELECT = 1u << 3;
    return true; /* SPI has no acknowledgement: adxl355_begin() reads the identity */
}

bool bus_read(uint8_t first_register, uint8_t *bytes, uint8_t count) {
    return transfer((uint8_t)(first_register << 1 | 1), 0, bytes, count);
}

bool bus_write(uint8_t register_, uint8_t byte) { return transfer((uint8_t)(register_ << 1), byte, 0, 1); }

#elif ACCELERATION == MPU6050

/* Pins PB2 clock, PB3 data. */
#define ADDRESS 0x68u
#define RUN 1u
#define START 2u
#define STOP 4u
#define ACKNOWLEDGE 8u
#define BUSY 1u
#define FAILED 2u

static bool step(uint32_t command) {
    uint32_t patience = 5000;
    volatile uint32_t pause = 8; /* the controller takes some cycles to call itself busy */
    I2C0_MCS = command;
    while (pause--) {
    }
    while ((I2C0_MCS & BUSY) && --patience) {
    }
    if (patience && !(I2C0_MCS & FAILED)) return true;
    I2C0_MCS = STOP;
    return false;
}

static bool begin(uint8_t register_) {
    GPIO_AFSEL(GPIO_B) |= 0x0C;
    GPIO_DEN(GPIO_B) |= 0x0C;
    GPIO_ODR(GPIO_B) |= 0x08;
#ifdef BOARD_LM3S6965
    GPIO_ODR(GPIO_B) |= 0x04;
#else
    GPIO_PCTL(GPIO_B) = (GPIO_PCTL(GPIO_B) & ~0xFF00u) | 0x3300;
#endif
    I2C0_MCR = 0x10;
    I2C0_MTPR = CLOCK_HZ / (20 * 400000); /* 357 kHz */
    I2C0_MSA = ADDRESS << 1;
    I2C0_MDR = register_;
    return step(START | RUN);
}

bool bus_read(uint8_t first_register, uint8_t *bytes, uint8_t count) {
    uint8_t i;
    if (!begin(first_register)) return false;
    I2C0_MSA = ADDRESS << 1 | 1;
    for (i = 0; i < count; i++) {
        uint32_t last = i + 1 == count;
        if (!step(RUN | (i == 0 ? START : 0) | (last ? STOP : ACKNOWLEDGE))) return false;
        bytes[i] = (uint8_t)I2C0_MDR;
    }
    return true;
}

bool bus_write(uint8_t register_, uint8_t byte) {
    if (!begin(register_)) return false;
    I2C0_MDR = byte;
    return step(RUN | STOP);
}

#else
typedef char no_bus_is_needed;
#endif
