"""How fast the wire's decoder is, and whether damage ever passes for a message."""

import random
import time

from firmware_protocol import Data, Decoder, SampleFormat, encode

TITLE = "The wire"

# What a serial driver hands over at once is between a few bytes and its buffer of 4 KB.
PIECE = 4096


def _frames(count: int, n: int, form: SampleFormat, seed: int) -> list[bytes]:
    rng = random.Random(seed)
    size = n * 2 * form.size
    return [encode(Data(i * n, i * n * 3906, 0, n, 2, form, rng.randbytes(size)), i) for i in range(count)]


def _decoded_mb_per_s(n: int, form: SampleFormat, count: int, at_once: int = PIECE) -> float:
    """Bytes of the wire per second, the best of five runs, all frames checked to have come."""
    wire = b"".join(_frames(count, n, form, seed=n))
    pieces = [wire[at : at + at_once] for at in range(0, len(wire), at_once)]
    best = float("inf")
    for _ in range(5):
        decoder = Decoder()
        start = time.perf_counter()
        frames = sum(len(decoder.feed(piece)) for piece in pieces)
        best = min(best, time.perf_counter() - start)
        if frames != count:
            raise AssertionError(f"{frames} of {count} frames came")
    return len(wire) / best / 1e6


def _wrong_of_damaged(count: int) -> tuple[int, int]:
    """Damage every frame; return how many were damaged, and how many came back as something else."""
    rng = random.Random(2)
    decoder, wrong = Decoder(), 0
    for frame in _frames(count, 8, SampleFormat.I16, seed=3):
        honest = Decoder().feed(frame)[0]
        wire = bytearray(frame)
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(len(wire) - 1)
            fault = rng.randrange(4)
            if fault == 0:
                wire[at] ^= 1 << rng.randrange(8)
            elif fault == 1:
                del wire[at]
            elif fault == 2:
                wire.insert(at, rng.randrange(256))
            else:
                wire[at:at] = wire[at : at + 4]
        for got in decoder.feed(bytes(wire)):
            wrong += got != honest
    return count, wrong


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    count = 5_000 if quick else 50_000
    least = _decoded_mb_per_s(16, SampleFormat.I16, count)
    most = _decoded_mb_per_s(60, SampleFormat.F64, count)
    damaged, wrong = _wrong_of_damaged(20_000 if quick else 400_000)
    return (
        f"Decoded on one core: {least:.0f} MB/s (16 samples of 2 x i16 a frame; at least 50 wanted) to "
        f"{most:.0f} MB/s (60 of 2 x f64).\n\nOf {damaged} frames with bits flipped, bytes dropped, inserted or "
        f"duplicated, {wrong} were taken for a message that was not sent."
    )


if __name__ == "__main__":
    print(run(quick=False))
