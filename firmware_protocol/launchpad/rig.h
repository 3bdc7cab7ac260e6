/* Your rig: which sensors hang on which pins, and their calibration. The one file to edit.
 *
 * Voltages are those at the board's pin: 0 to 3.3 V, never more. The converter compares with the board's 3.3 V;
 * sensors fed from the same 3.3 V do not notice when it is 3.2 V (see docs/board.md).
 */
#ifndef RIG_H
#define RIG_H

#include "sensors.h"

#define BAUD 115200
#define UNIQUE_ID "launchpad-1" /* the station tells boards apart by this */

#define CLOCK_HZ 50000000  /* Hz */
#define CLOCK_ERROR_PPM 50 /* by how much it may be off: a crystal's, by its data sheet */
#define REFERENCE_V 3.3   /* V at the pin 3.3V, measured */

/* ---- Channel 0: displacement. Any sensor with a voltage: potentiometer, LVDT conditioner, laser ---- */

#define DISPLACEMENT_INPUT 0          /* AIN0: pin PE3 */
#define DISPLACEMENT_M_PER_V 0.015152 /* a slide potentiometer of 50 mm between 0 V and 3.3 V */
#define DISPLACEMENT_ZERO_V 1.65      /* where displacement is called 0; the station finds the true zero */
#define DISPLACEMENT_DELAY_S 0.0      /* of the sensor's own filter, e.g. R C; 0.0023 for the LVDT on the page */
#define DISPLACEMENT_SENSOR "slide potentiometer 50 mm"

/* ---- Channel 1: acceleration. ADXL335, ADXL355 or MPU6050 ---- */

#ifndef ACCELERATION
#define ACCELERATION ADXL335
#endif

#define ACCELERATION_INPUT 1       /* AIN1: pin PE2; ADXL335 only */
#define ACCELERATION_V_PER_G 0.330 /* ADXL335 at 3.3 V: turn it over, (V up - V down) / 2 */
#define ACCELERATION_ZERO_V 1.65   /* (V up + V down) / 2 */

#define ACCELERATION_COUNTS_PER_G ACCELERATION_COUNTS_BY_DATA_SHEET /* ADXL355, MPU6050: turn it over */
#define ACCELERATION_AXIS 0         /* 0 x, 1 y, 2 z; ADXL355, MPU6050 */
#define ACCELERATION_SIGN +1        /* -1: the axis points against positive displacement */

/* ---- The holder, if there is one: a magnet on a stepper (docs/firmware.md). make HOLDER=1 ---- */

#define HOLDER_LOW_UM 0          /* displacements that may be held, um: both on the carriage's side */
#define HOLDER_HIGH_UM 25000
#define HOLDER_SIDE +1           /* -1: the carriage stands on the side of negative displacement */
#define HOLDER_END_UM 30000      /* from where the magnet touches the mass at rest to the end switch */
#define HOLDER_CLEAR_UM 1000     /* how far the carriage backs off when it lets go */
#define HOLDER_STEPS_PER_MM 100  /* 200 steps a turn, 2 mm a turn */
#define HOLDER_STEPS_HZ 500      /* 5 mm/s */

#endif
