/* Your rig: which sensors hang on which pins, and their calibration. The one file to edit.
 *
 * Voltages are those at the board's pin. The converter compares with the AREF pin, which is wired to the
 * board's own 3.3 V; sensors fed from the same 3.3 V do not notice when it is 3.2 V (see docs/board.md).
 */
#ifndef RIG_H
#define RIG_H

#include "src/sensors.h"

#define BAUD 115200
#define UNIQUE_ID "mega-1" /* the station tells boards apart by this */

/* Hz. A Mega's ceramic resonator may be off by 0.5 %, which the station reports: put the true number here. */
#define CLOCK_HZ 16000000
#define CLOCK_ERROR_PPM 5000 /* by how much it may be off; 300 once measured: it drifts with the temperature */

#define REFERENCE_V 3.3 /* V at the pin AREF, measured */
#define READINGS 16     /* per channel and sample at 256 Hz and below, fewer above: a power of two */

/* ---- Channel 0: displacement. Any sensor with a voltage: potentiometer, LVDT conditioner, laser ---- */

#define DISPLACEMENT_PIN 0            /* A0 */
#define DISPLACEMENT_M_PER_V 0.015152 /* a slide potentiometer of 50 mm between 0 V and 3.3 V */
#define DISPLACEMENT_ZERO_V 1.65      /* where displacement is called 0; the station finds the true zero */
#define DISPLACEMENT_DELAY_S 0.0      /* of the sensor's own filter, e.g. R C; 0.0023 for the LVDT on the page */
#define DISPLACEMENT_SENSOR "slide potentiometer 50 mm"

/* ---- Channel 1: acceleration. ADXL335, ADXL355 or MPU6050 ---- */

#ifndef ACCELERATION
#define ACCELERATION ADXL335
#endif

#define ACCELERATION_PIN 1         /* A1; ADXL335 only */
#define ACCELERATION_V_PER_G 0.330 /* ADXL335 at 3.3 V: turn it over, (V up - V down) / 2 */
#define ACCELERATION_ZERO_V 1.65   /* (V up + V down) / 2 */

#define ACCELERATION_COUNTS_PER_G ACCELERATION_COUNTS_BY_DATA_SHEET /* ADXL355, MPU6050: turn it over */
#define ACCELERATION_AXIS 0         /* 0 x, 1 y, 2 z; ADXL355, MPU6050 */
#define ACCELERATION_SIGN +1        /* -1: the axis points against positive displacement */

/* ---- The holder, if there is one: a magnet on a stepper (docs/firmware.md). BOARD_HOLDER 1 in src/sizes.h ---- */

#define HOLDER_LOW_UM 0          /* displacements that may be held, um: both on the carriage's side */
#define HOLDER_HIGH_UM 25000
#define HOLDER_SIDE +1           /* -1: the carriage stands on the side of negative displacement */
#define HOLDER_END_UM 30000      /* from where the magnet touches the mass at rest to the end switch */
#define HOLDER_CLEAR_UM 1000     /* how far the carriage backs off when it lets go */
#define HOLDER_STEPS_PER_MM 100  /* 200 steps a turn, 2 mm a turn */
#define HOLDER_STEPS_HZ 500      /* 5 mm/s */

#endif
