"""Expected evidence against what a release gave, as a picture for the docs."""

from pathlib import Path

import numpy as np

PICTURE = Path(__file__).resolve().parent.parent / "docs" / "pictures" / "guide_expected.svg"
LEAST, MOST = 0.1, 1e7


def expected_and_achieved(pairs: list[tuple[float, float, float]], file: Path = PICTURE) -> None:
    """Draw (expected, scatter, achieved) in nats, both axes logarithmic; what lies below 0.1 nats stands at the edge."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "guide"
    from matplotlib import pyplot as plt

    expected, scatter, achieved = (np.array(column) for column in zip(*pairs, strict=True))
    low = np.minimum(scatter, expected - LEAST).clip(0.0)
    figure, axes = plt.subplots(figsize=(5.6, 4.6), layout="constrained")
    axes.plot([LEAST, MOST], [LEAST, MOST], color="0.4", linewidth=1.0, label="as expected")
    axes.fill_between(
        [LEAST, MOST], [LEAST / 5, MOST / 5], [LEAST * 5, MOST * 5], color="0.9", label="within a factor of 5"
    )
    axes.errorbar(
        expected.clip(LEAST), achieved.clip(LEAST), xerr=[low, scatter], fmt="o", markersize=4, linewidth=0.8, color="tab:blue"
    )  # fmt: skip
    axes.set(xscale="log", yscale="log", xlim=(LEAST, MOST), ylim=(LEAST, MOST))
    axes.set_xlabel("expected evidence, nats (bar: standard deviation)")
    axes.set_ylabel("evidence that the release gave, nats")
    axes.legend(loc="upper left", frameon=False)
    file.parent.mkdir(exist_ok=True)
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)
