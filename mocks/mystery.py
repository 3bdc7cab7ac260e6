"""`python -m mocks.mystery --seed N ...`: the bench's double with an effect hidden that its seed draws.

What it is depends on the seed alone and stands in the `--truth` file only.
"""

from __future__ import annotations

import math
import sys

import numpy as np

from mocks import cli
from mocks.generate import PHYSICS
from mocks.simulated_board import SimulatedBoard

STRENGTHS = (0.005, 0.03)
FAULTY_SENSOR = 0.2
#: What every bench has, and what came later: a seed hides today what it always hid.
PLAIN = ("linear_stiffness", "viscous_damping", "coulomb_friction")
LATER = (
    "signed_quadratic_stiffness", "impact_with_loss", "dahl_friction", "settling_stiffness",
    "fading_damping", "fading_friction",
)  # fmt: skip
#: Not the lag, which is always there and corrected, nor the coupling capacitor, which at these strengths is nothing but
#: a lag; nor the gain, which without certificates nobody can call wrong.
FAULTS = ("offset_drift", "clipping", "mains_hum", "dropouts")
MOST_DRAWS = 20


def draw(seed: int, again: int = 0) -> str:
    """Return NAME:STRENGTH of what is hidden; `again` counts the draws that could not be built."""
    random = np.random.default_rng([seed, 41, again])
    names = (
        FAULTS if random.random() < FAULTY_SENSOR else tuple(n for n in PHYSICS if n not in (*PLAIN, *LATER))
    )
    name = names[int(random.integers(len(names)))]
    low, high = (math.log(strength) for strength in STRENGTHS)
    return f"{name}:{math.exp(random.uniform(low, high)):.5f}"


def main(argv: list[str] | None = None) -> int:
    """Run the double as `python -m mocks` does, with one thing hidden in it."""
    arguments = sys.argv[1:] if argv is None else argv
    options = cli.parser().parse_args(arguments)
    for again in range(MOST_DRAWS):
        hidden = draw(options.seed, again)
        try:
            SimulatedBoard(cli.parser().parse_args([*arguments, "--hide", hidden]))
        except ValueError:  # no size of it reaches the strength on this bench
            continue
        return cli.main([*arguments, "--hide", hidden])
    raise SystemExit(f"nothing could be hidden with seed {options.seed}; try another")


if __name__ == "__main__":
    sys.exit(main())
