/* Bits of 64-bit numbers in, one a line in hexadecimal; out: the bits of the same number after a way through a
 * 32-bit one, both conversions made by wire.h. */
#include <inttypes.h>
#include <stdio.h>

#include "wire.h"

int main(void) {
    uint64_t bits;
    while (scanf("%" SCNx64, &bits) == 1) printf("%016" PRIx64 "\n", wire_widened(wire_narrowed(bits)));
    return 0;
}
