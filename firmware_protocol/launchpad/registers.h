/* The registers that are used, the same in TI's LM3S6965 and TM4C123 but where said. Names as in the data sheets. */
#ifndef REGISTERS_H
#define REGISTERS_H

#include <stdint.h>

#define REGISTER(address) (*(volatile uint32_t *)(uintptr_t)(address))

/* System control */
#define SYSCTL_RIS REGISTER(0x400FE050)
#define SYSCTL_RESC REGISTER(0x400FE05C)
#define SYSCTL_RCC REGISTER(0x400FE060)
#define SYSCTL_RCGC0 REGISTER(0x400FE100)
#define SYSCTL_RCGC1 REGISTER(0x400FE104)
#define SYSCTL_RCGC2 REGISTER(0x400FE108)
#define RIS_PLL_LOCKED (1u << 6)
#define RCC_USE_DIVIDER (1u << 22)
#define RCC_PLL_OFF (1u << 13)
#define RCC_BYPASS (1u << 11)
#define RCGC0_ADC0 (1u << 16)
#define RCGC0_ADC_1_MSPS (3u << 8)
#define RCGC1_TIMER0 (1u << 16)
#define RCGC1_TIMER1 (1u << 17)
#define RCGC1_I2C0 (1u << 12)
#define RCGC1_SSI0 (1u << 4)
#define RCGC1_UART0 (1u << 0)
#define RCGC2_GPIOA (1u << 0)
#define RCGC2_GPIOB (1u << 1)
#define RCGC2_GPIOD (1u << 3)
#define RCGC2_GPIOE (1u << 4)

/* Pins of port A (UART0, SSI0), B (I2C0), D (holder), E (converter) */
#define GPIO_A 0x40004000u
#define GPIO_B 0x40005000u
#define GPIO_D 0x40007000u
#define GPIO_E 0x40024000u
#define GPIO_DATA(port, pins) REGISTER((port) + ((pins) << 2))
#define GPIO_DIR(port) REGISTER((port) + 0x400)
#define GPIO_AFSEL(port) REGISTER((port) + 0x420)
#define GPIO_ODR(port) REGISTER((port) + 0x50C)
#define GPIO_PUR(port) REGISTER((port) + 0x510)
#define GPIO_DEN(port) REGISTER((port) + 0x51C)
#define GPIO_AMSEL(port) REGISTER((port) + 0x528) /* TM4C123 only */
#define GPIO_PCTL(port) REGISTER((port) + 0x52C)  /* TM4C123 only */

/* UART 0 */
#define UART0_DR REGISTER(0x4000C000)
#define UART0_FR REGISTER(0x4000C018)
#define UART0_IBRD REGISTER(0x4000C024)
#define UART0_FBRD REGISTER(0x4000C028)
#define UART0_LCRH REGISTER(0x4000C02C)
#define UART0_CTL REGISTER(0x4000C030)
#define UART0_IM REGISTER(0x4000C038)
#define UART0_ICR REGISTER(0x4000C044)
#define FR_SEND_FULL (1u << 5)
#define FR_RECEIVE_EMPTY (1u << 4)

/* Timers 0 and 1, 32 bits */
#define TIMER0_CFG REGISTER(0x40030000)
#define TIMER0_TAMR REGISTER(0x40030004)
#define TIMER0_CTL REGISTER(0x4003000C)
#define TIMER0_TAILR REGISTER(0x40030028)
#define TIMER1_CFG REGISTER(0x40031000)
#define TIMER1_TAMR REGISTER(0x40031004)
#define TIMER1_CTL REGISTER(0x4003100C)
#define TIMER1_IMR REGISTER(0x40031018)
#define TIMER1_ICR REGISTER(0x40031024)
#define TIMER1_TAILR REGISTER(0x40031028)
#define TIMER_PERIODIC 2u
#define TIMER_RUNS (1u << 0)
#define TIMER_TRIGGERS (1u << 5)

/* Converter 0, sequence 0: up to eight readings at each trigger */
#define ADC0_ACTSS REGISTER(0x40038000)
#define ADC0_IM REGISTER(0x40038008)
#define ADC0_ISC REGISTER(0x4003800C)
#define ADC0_EMUX REGISTER(0x40038014)
#define ADC0_PSSI REGISTER(0x40038028)
#define ADC0_SAC REGISTER(0x40038030)
#define ADC0_SSMUX0 REGISTER(0x40038040)
#define ADC0_SSCTL0 REGISTER(0x40038044)
#define ADC0_SSFIFO0 REGISTER(0x40038048)
#define ADC0_SSFSTAT0 REGISTER(0x4003804C)
#define FIFO_EMPTY (1u << 8)
#define TRIGGER_BY_TIMER 5u

/* SPI (SSI 0) and I2C 0 */
#define SSI0_CR0 REGISTER(0x40008000)
#define SSI0_CR1 REGISTER(0x40008004)
#define SSI0_DR REGISTER(0x40008008)
#define SSI0_SR REGISTER(0x4000800C)
#define SSI0_CPSR REGISTER(0x40008010)
#define I2C0_MSA REGISTER(0x40020000)
#define I2C0_MCS REGISTER(0x40020004)
#define I2C0_MDR REGISTER(0x40020008)
#define I2C0_MTPR REGISTER(0x4002000C)
#define I2C0_MCR REGISTER(0x40020020)

/* The Cortex-M core */
#define SYSTICK_CTRL REGISTER(0xE000E010)
#define SYSTICK_LOAD REGISTER(0xE000E014)
#define SYSTICK_VAL REGISTER(0xE000E018)
#define NVIC_ISER0 REGISTER(0xE000E100)
#define NVIC_ICPR0 REGISTER(0xE000E280)
#define NVIC_IPR(irq) (*(volatile uint8_t *)(uintptr_t)(0xE000E400 + (irq)))
#define SCB_ICSR REGISTER(0xE000ED04)
#define SCB_AIRCR REGISTER(0xE000ED0C)
#define SCB_SHPR3 REGISTER(0xE000ED20)
#define ICSR_CLOCK_PENDING (1u << 26)

#define IRQ_UART0 5
#define IRQ_ADC0_SS0 14
#define IRQ_TIMER1A 21

void clock_interrupt(void);
void port_interrupt(void);
void converter_interrupt(void);
void holder_interrupt(void);

#endif
