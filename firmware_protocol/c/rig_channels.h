/* The two channels of a board, calculated from its rig.h: volts at the pin, or counts of a sensor, to SI units.
 *
 * Converter readings are summed to 14 bits (0 to 16383 for 0 V to REFERENCE_V) and sent less 8192. A converter of B bits
 * rounds down, by half of its step on average: CONVERTER_BITS says how much that is.
 */
#ifndef RIG_CHANNELS_H
#define RIG_CHANNELS_H

#include "hardware.h"

#define GRAVITY 9.80665
#define STEP_V (REFERENCE_V / 16384.0)
#define MIDDLE_V (REFERENCE_V / 2 + REFERENCE_V / (2L << CONVERTER_BITS)) /* of the number 0 */
#define TEXT(s) {s, sizeof s - 1}

#define DISPLACEMENT_SCALE (STEP_V * DISPLACEMENT_M_PER_V)
#define DISPLACEMENT_OFFSET ((MIDDLE_V - DISPLACEMENT_ZERO_V) * DISPLACEMENT_M_PER_V)

#if ACCELERATION == ADXL335
#define ACCELERATION_SCALE (ACCELERATION_SIGN * STEP_V / ACCELERATION_V_PER_G * GRAVITY)
#define ACCELERATION_OFFSET \
    (ACCELERATION_SIGN * (MIDDLE_V - ACCELERATION_ZERO_V) / ACCELERATION_V_PER_G * GRAVITY)
#define ACCELERATION_SPAN 8176
#define ACCELERATION_LOWEST 8192
#define ACCELERATION_DELAY_S 0.0032 /* 32 kOhm inside, 0.1 uF outside */
#define ACCELERATION_SENSOR "ADXL335"
#define acceleration_begin() true
#else
#define ACCELERATION_SCALE (ACCELERATION_SIGN * GRAVITY / ACCELERATION_COUNTS_PER_G)
#define ACCELERATION_OFFSET 0
#define ACCELERATION_SPAN 32767
#define ACCELERATION_LOWEST 32768.0
#if ACCELERATION == ADXL355
#define ACCELERATION_COUNTS_BY_DATA_SHEET ADXL355_COUNTS_PER_G
#define ACCELERATION_DELAY_S ADXL355_DELAY_S
#define ACCELERATION_SENSOR "ADXL355"
#define acceleration_begin() adxl355_begin()
#define acceleration_read(number) adxl355_read(ACCELERATION_AXIS, number)
#elif ACCELERATION == MPU6050
#define ACCELERATION_COUNTS_BY_DATA_SHEET MPU6050_COUNTS_PER_G
#define ACCELERATION_DELAY_S MPU6050_DELAY_S
#define ACCELERATION_SENSOR "MPU-6050"
#define acceleration_begin() mpu6050_begin()
#define acceleration_read(number) mpu6050_read(ACCELERATION_AXIS, number)
#else
#error "ACCELERATION in rig.h: ADXL335, ADXL355 or MPU6050"
#endif
#endif

/* DESCRIBE: header and checksum, format, count, and for each channel a length, seven numbers and four texts. */
typedef char texts_fit_a_frame[12 + 2 + BOARD_CHANNELS * (2 + 7 * 8 + 4) + sizeof "xdisplacementm" - 1 +
                                           sizeof DISPLACEMENT_SENSOR - 1 + sizeof "aaccelerationm/s^2" - 1 +
                                           sizeof ACCELERATION_SENSOR - 1 <= BOARD_FRAME
                                   ? 1
                                   : -1];

#if BOARD_HOLDER
#if HOLDER_SIDE * HOLDER_LOW_UM < 0 || HOLDER_SIDE * HOLDER_HIGH_UM < 0 || HOLDER_LOW_UM >= HOLDER_HIGH_UM
#error "HOLDER_LOW_UM and HOLDER_HIGH_UM in rig.h: both on the carriage's side, the lower one first"
#endif
#if HOLDER_END_UM < HOLDER_CLEAR_UM + HOLDER_SIDE * (HOLDER_SIDE > 0 ? HOLDER_HIGH_UM : HOLDER_LOW_UM)
#error "HOLDER_END_UM in rig.h: the end switch must lie beyond the farthest displacement and HOLDER_CLEAR_UM"
#endif
#if HOLDER_STEPS_HZ > 5 * HOLDER_STEPS_PER_MM
#error "HOLDER_STEPS_HZ in rig.h: faster than 5 mm/s"
#endif
const struct hardware_holder hardware_holder = {
    HOLDER_LOW_UM, HOLDER_HIGH_UM, HOLDER_SIDE, HOLDER_END_UM, HOLDER_CLEAR_UM, HOLDER_STEPS_PER_MM, HOLDER_STEPS_HZ,
};
#endif

#define SIZE_OF(scale) ((scale) < 0 ? -(scale) : (scale))

const struct wire_channel hardware_channels[BOARD_CHANNELS] = {
    {DISPLACEMENT_SCALE, DISPLACEMENT_OFFSET, 0,
     DISPLACEMENT_OFFSET - 8192 * SIZE_OF(DISPLACEMENT_SCALE), DISPLACEMENT_OFFSET + 8176 * SIZE_OF(DISPLACEMENT_SCALE),
     SIZE_OF(DISPLACEMENT_SCALE), DISPLACEMENT_DELAY_S, TEXT("x"), TEXT("displacement"), TEXT("m"),
     TEXT(DISPLACEMENT_SENSOR)},
    {ACCELERATION_SCALE, ACCELERATION_OFFSET, 0,
     ACCELERATION_OFFSET - ACCELERATION_LOWEST * SIZE_OF(ACCELERATION_SCALE),
     ACCELERATION_OFFSET + ACCELERATION_SPAN * SIZE_OF(ACCELERATION_SCALE), SIZE_OF(ACCELERATION_SCALE),
     ACCELERATION_DELAY_S, TEXT("a"), TEXT("acceleration"), TEXT("m/s^2"), TEXT(ACCELERATION_SENSOR)},
};

#endif
