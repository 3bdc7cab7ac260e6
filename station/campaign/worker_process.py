"""The start of a worker's process: imported before any numerics, which take their threads from the environment."""

import multiprocessing
import os
import signal
import threading

from station.library_messages import say_in_one_line

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def begin() -> None:
    """Take one thread for the numerics, leave Ctrl-C to the process that gave the work, and end with it, however it ends."""
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    say_in_one_line()
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
