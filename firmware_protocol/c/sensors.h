/* Accelerometers with a digital output, over a bus that the board's own file gives: ADXL355 by SPI, MPU-6050 by I2C.
 *
 * Both sample by a clock of their own, and a reading is as old as their last sample: up to 0.25 ms (ADXL355 at
 * 4000 Hz) or 1 ms (MPU-6050 at 1000 Hz), which is noise of that much of time. Registers by the data sheets:
 * ADXL354/ADXL355 rev. B, MPU-6000/6050 register map rev. 4.2.
 */
#ifndef SENSORS_H
#define SENSORS_H

#include <stdbool.h>
#include <stdint.h>

/* What ACCELERATION in rig.h may be. */
#define ADXL335 1 /* analog */
#define ADXL355 2
#define MPU6050 3

#ifdef __cplusplus
extern "C" {
#endif

/* Given by the board's file: transfers on SPI (mode 0, at most 10 MHz) or I2C (address 0x68, 400 kHz); they end
 * within 1 ms. False when nothing answers. */
bool bus_read(uint8_t first_register, uint8_t *bytes, uint8_t count);
bool bus_write(uint8_t register_, uint8_t byte);

#ifdef __cplusplus
}
#endif

/* 2 g: 20 bits, 256000 counts a g, of which the upper 16 are sent. Low-pass 1000 Hz, samples at 4000 Hz. */
#define ADXL355_COUNTS_PER_G 16000.0
#define ADXL355_DELAY_S 0.00063 /* 2.52 samples of 4000 Hz */

static inline bool adxl355_begin(void) {
    uint8_t identity[2];
    return bus_read(0x00, identity, 2) && identity[0] == 0xAD && identity[1] == 0x1D && bus_write(0x28, 0x00) &&
           bus_write(0x2C, 0x01) && bus_write(0x2D, 0x00);
}

static inline bool adxl355_read(uint8_t axis, int16_t *number) {
    uint8_t bytes[2];
    if (!bus_read((uint8_t)(0x08 + 3 * axis), bytes, 2)) return false;
    *number = (int16_t)((uint16_t)bytes[0] << 8 | bytes[1]);
    return true;
}

/* 2 g, low-pass 44 Hz, samples at 1000 Hz; the gyroscopes stay on, since the clock comes from them. */
#define MPU6050_COUNTS_PER_G 16384.0
#define MPU6050_DELAY_S 0.0049

static inline bool mpu6050_begin(void) {
    uint8_t identity;
    return bus_write(0x6B, 0x01) && bus_read(0x75, &identity, 1) && (identity & 0x7E) == 0x68 &&
           bus_write(0x1A, 0x03) && bus_write(0x1C, 0x00);
}

static inline bool mpu6050_read(uint8_t axis, int16_t *number) {
    uint8_t bytes[2];
    if (!bus_read((uint8_t)(0x3B + 2 * axis), bytes, 2)) return false;
    *number = (int16_t)((uint16_t)bytes[0] << 8 | bytes[1]);
    return true;
}

#endif
