/* The whole firmware: begin, then step for ever. */
#include "board.h"
#include "hardware.h"

int main(int count, char **arguments) {
    hardware_begin(count, arguments);
    board_begin();
    for (;;) {
        board_step();
        hardware_wait();
    }
}
