"""Lengths that Fourier transforms are quick at, without the twentieth of a second of loading `scipy.fft`."""


def fast_length(least: int) -> int:
    """Return the next number from `least` up whose prime factors are 11 at most."""
    length = max(least, 1)
    while True:
        rest = length
        for prime in (2, 3, 5, 7, 11):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return length
        length += 1
