"""The curves in words: what the two panels show, for a caption."""

from collections.abc import Sequence

from identify.curves.laid_over import DecayCurves


def curves_caption(names: Sequence[str], found: DecayCurves) -> str:
    """Explain points, bands and lines of the curves; `names` are those of the releases that were given."""
    many = len(found.releases) > 1
    kept = [names[curve.release] for curve in found.releases]
    whose = f"each of {len(kept)} releases ({', '.join(kept)})" if many else "this release"
    words = [
        f"How frequency and damping of {whose} change as the oscillation dies down. Each point is one stretch of the decay, "
        "a cycle or more; its band is two standard errors, from the scatter of its neighbours. The damping ratio is that of "
        "a viscous damper with the same loss: each cycle loses 4π times this ratio of the energy. A linear spring "
        "with viscous damping gives two level lines."
    ]
    if any(laid.curves for laid in found.laws):
        words.append(
            "Thin line: the usual model, as it is fitted. Thick line: the model with the named effects, "
            "simulated and evaluated in the same way. Broken line: an effect that explains nearly as much."
        )
        if many:
            words.append("Every line has the linear stiffness and viscous damping of its own release.")
    left = [name for place, name in enumerate(names) if place not in {c.release for c in found.releases}]
    if left:
        words.append(f"Too short for a curve: {', '.join(left)}.")
    return " ".join(words)
