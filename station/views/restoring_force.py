"""The Restoring force tab: the surface with the measured points, its sections, the orders, the significance."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.restoring_force.restoring_force import RestoringForceResult
from station.story.engineering_values import Weighing
from station.story.identification import Identification
from station.text.numbers import scale, typeset
from station.views import identification_figures as figures, log, palette
from station.views.palette import Look
from station.views.tabs import refused

ROOT = "/restoring_force/surface"
MOST_POINTS = 4000


def tab(stream: rr.RecordingStream, look: Look, name: str, result: Identification) -> rrb.Container:
    """Show what the restoring force surface found; only the refusal where there is none."""
    found = result.restoring_force
    if found is None:
        return refused(stream, "Restoring force", result.refusals.get("restoring_force", ""))
    _draw_surface(stream, found, result.weighing)
    surface = rrb.Spatial3DView(
        origin=ROOT,
        name="Restoring force surface (points: measured)",
        line_grid=False,
        eye_controls=rrb.EyeControls3D(
            position=(-1.55, -2.9, 1.55), look_target=(0.08, 0.0, -0.1), eye_up=(0.0, 0.0, 1.0)
        ),
    )
    title = "Error against order by both methods, and significance of the terms"
    pictures = rrb.Vertical(
        log.picture(
            stream, "Sections", "/restoring_force/sections", figures.sections(found, result.weighing, look)
        ),
        log.picture(stream, title, "/restoring_force/orders", figures.orders(result, look)),
    )
    return rrb.Horizontal(surface, pictures, column_shares=[1, 1.05], name="Restoring force")


def _draw_surface(stream: rr.RecordingStream, found: RestoringForceResult, weighing: Weighing) -> None:
    """Draw the surface and the measured points in a cube: displacement, velocity and force each from -1 to 1."""
    import matplotlib  # which the figures have loaded blind to the working folder

    length, (size, newton) = weighing.unit, weighing.force_scale
    measured = (found.displacement, found.velocity, size * found.force)
    reach = np.array([_round_up(np.max(np.abs(values))) for values in measured])
    vertices, triangles = figures.mesh(found)
    placed = np.clip(vertices * (1.0, 1.0, size) / reach, -1.2, 1.2)
    every = max(1, len(found.force) // MOST_POINTS)
    points = np.column_stack(measured)[::every] / reach
    steps = np.linspace(-1, 1, 5)
    floor = [[[x, -1, -1], [x, 1, -1]] for x in steps] + [[[-1, y, -1], [1, y, -1]] for y in steps]
    axes = [[[-1, -1, -1], [1, -1, -1]], [[1, -1, -1], [1, 1, -1]], [[-1, -1, -1], [-1, -1, 1]]]
    ends = [[0, -1.18, -1.02], [1.18, 0.1, -1.02], [-1, -1, 1.12]]
    colours = [palette.DISPLACEMENT, palette.VELOCITY, palette.ACCELERATION]
    factor, unit = scale("displacement", length)
    names = [
        f"displacement ± {reach[0] * factor:g} {unit}",
        f"velocity ± {reach[1]:g} {length}/s",
        typeset(f"{weighing.worded()} ± {reach[2]:g} {newton}"),
    ]
    for part, drawn in (
        (
            "fit",
            rr.Mesh3D(
                vertex_positions=placed,
                triangle_indices=triangles,
                vertex_colors=matplotlib.colormaps["viridis"](
                    (np.clip(placed[:, 2], -1, 1) + 1) / 2, bytes=True
                ),
                face_rendering="DoubleSided",
            ),
        ),
        ("measured", rr.Points3D(points, colors=palette.MEASURED, radii=0.007)),
        ("floor", rr.LineStrips3D(floor, colors=palette.REFERENCE, radii=0.002)),
        ("axes", rr.LineStrips3D(axes, colors=colours, radii=0.006)),
        ("names", rr.Points3D(ends, labels=names, colors=colours, radii=0.008, show_labels=True)),
    ):
        stream.log(f"{ROOT}/{part}", drawn, static=True)


def _round_up(value: float) -> float:
    """Round up to a number that reads well on an axis."""
    if not value > 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(
        next(step * power for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if step * power >= value * 0.999)
    )
