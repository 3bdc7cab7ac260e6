/* What stands before main() on a Cortex-M without a C library: vectors, memory, and <string.h>. */
#include <stdint.h>
#include <string.h>

#include "registers.h"
#include "sizes.h"

extern uint32_t data_begin[], data_end[], data_image[], bss_begin[], bss_end[], stack_top[];

int main(int count, char **arguments);

void *memcpy(void *to, const void *from, size_t count) {
    uint8_t *out = to;
    const uint8_t *in = from;
    while (count--) *out++ = *in++;
    return to;
}

void *memmove(void *to, const void *from, size_t count) {
    uint8_t *out = to;
    const uint8_t *in = from;
    if (out <= in) return memcpy(to, from, count);
    while (count--) out[count] = in[count];
    return to;
}

void *memset(void *to, int byte, size_t count) {
    uint8_t *out = to;
    while (count--) *out++ = (uint8_t)byte;
    return to;
}

size_t strlen(const char *string) {
    size_t count = 0;
    while (string[count]) count++;
    return count;
}

void reset(void) {
    memcpy(data_begin, data_image, (size_t)((char *)data_end - (char *)data_begin));
    memset(bss_begin, 0, (size_t)((char *)bss_end - (char *)bss_begin));
    main(0, 0);
    for (;;) {
    }
}

/* Whatever went wrong, boot again: the station sees another boot_id. */
static void fault(void) {
    SCB_AIRCR = 0x05FA0004;
    for (;;) {
    }
}

typedef void (*vector)(void);

__attribute__((section(".vectors"), used)) static const vector vectors[16 + 32] = {
    (vector)(uintptr_t)stack_top,
    reset,
    fault, fault, fault, fault, fault, /* NMI, hard fault, memory, bus, usage */
    [15] = clock_interrupt,
    [16 + IRQ_UART0] = port_interrupt,
    [16 + IRQ_ADC0_SS0] = converter_interrupt,
#if BOARD_HOLDER
    [16 + IRQ_TIMER1A] = holder_interrupt,
#endif
};
