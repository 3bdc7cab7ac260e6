"""The picture of detection against strength: the station, its peers, and where nobody can see anything any more."""

from pathlib import Path

import numpy as np

PICTURE = Path(__file__).resolve().parent.parent / "docs" / "pictures" / "detection.png"
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
_MARKS = ("o", "s", "^", "D")


def visible(drops: np.ndarray, at: float, strengths: np.ndarray, seen: float) -> np.ndarray:
    """Return the share of records, in %, whose drop of chi-square reaches `seen` at each strength.

    `drops` were found at the strength `at`; a drop grows with the square of the strength.
    """
    scaled = drops[:, None] * (strengths[None, :] / at) ** 2
    return np.asarray(100.0 * np.mean(scaled >= seen, axis=0))


def draw(
    strengths: tuple[float, ...], shares: dict[str, list[float]], bound: tuple[np.ndarray, np.ndarray]
) -> Path:
    """Draw the share named first (%) over strength for each method, the last one boldly, and the bound as a shade."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(8.0, 4.5), dpi=110, layout="constrained")
    axes.fill_between(100.0 * bound[0], bound[1], 100.0, color="0.85", step="post", label="nobody can see it")
    for i, (name, share) in enumerate(shares.items()):
        ours = i == len(shares) - 1
        axes.plot(100.0 * np.array(strengths), share, _MARKS[i % 4] + "-", color=_COLOURS[i % 4],
                  lw=2.5 if ours else 1.2, label=name)  # fmt: skip
    axes.set(xscale="log", xlabel="rms of the effect's force over the total, %", ylabel="named first, %",
             ylim=(0, 102), xlim=(100.0 * strengths[0], 100.0 * strengths[-1]))  # fmt: skip
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right", fontsize=9)
    figure.savefig(PICTURE)
    plt.close(figure)
    return PICTURE
