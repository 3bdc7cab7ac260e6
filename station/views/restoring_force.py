"""The Restoring force tab: the surface with the measured points, its sections, the orders, the significance."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.restoring_force.restoring_force import RestoringForceResult
from station.story.identification import Identification
from station.text.numbers import scale
from station.views import identification_figures as figures
from station.views import log, palette
from station.views.log import Array

ROOT = "/restoring_force"
MOST_POINTS = 4000


def write(stream: rr.RecordingStream, name: str, result: Identification) -> None:
    """Log what the restoring force surface found; only the refusal when there is none."""
    found = result.restoring_force
    if found is None:
        reason = result.refusals.get("restoring_force", "")
        log.markdown(stream, f"{ROOT}/refusal", f"## Not identified\n\n{reason}")
        return
    cube = Cube(found, result.decay.unit)
    _surface(stream, found, cube)
    every = max(1, len(found.force) // MOST_POINTS)
    placed = cube.place(found.displacement[::every], found.velocity[::every], found.force[::every])
    measured = rr.Points3D(placed, colors=palette.MEASURED, radii=0.007)
    stream.log(f"{ROOT}/surface/measured", measured, static=True)
    cube.draw(stream)
    log.picture(stream, f"{ROOT}/sections", figures.sections(found, result.decay.unit, palette.SCREEN))
    log.picture(stream, f"{ROOT}/orders", figures.orders(result, palette.SCREEN))


class Cube:
    """The normalised cube: displacement, velocity and force each from -1 to 1, with axes in real units."""

    def __init__(self, found: RestoringForceResult, length: str) -> None:
        self.scale = np.array(
            [_round_up(np.max(np.abs(v))) for v in (found.displacement, found.velocity, found.force)]
        )
        factor, unit = scale("displacement", length)
        self.labels = (
            f"displacement ± {self.scale[0] * factor:g} {unit}",
            f"velocity ± {self.scale[1]:g} {length}/s",
            f"force per unit mass ± {self.scale[2]:g} {length}/s²",
        )

    def place(self, u: Array, v: Array, force: Array) -> Array:
        """Return points (n, 3) in the cube."""
        placed: Array = np.column_stack([np.ravel(u), np.ravel(v), np.ravel(force)]) / self.scale
        return placed

    def draw(self, stream: rr.RecordingStream) -> None:
        """Log the frame: a floor with grid lines, and one labelled axis for each quantity."""
        steps = np.linspace(-1, 1, 5)
        floor = [[[x, -1, -1], [x, 1, -1]] for x in steps] + [[[-1, y, -1], [1, y, -1]] for y in steps]
        faint = palette.REFERENCE
        stream.log(f"{ROOT}/surface/floor", rr.LineStrips3D(floor, colors=faint, radii=0.002), static=True)
        axes = [[[-1, -1, -1], [1, -1, -1]], [[1, -1, -1], [1, 1, -1]], [[-1, -1, -1], [-1, -1, 1]]]
        colours = [palette.DISPLACEMENT, palette.VELOCITY, palette.ACCELERATION]
        stream.log(f"{ROOT}/surface/axes", rr.LineStrips3D(axes, colors=colours, radii=0.006), static=True)
        ends = [[0, -1.18, -1.02], [1.18, 0.1, -1.02], [-1, -1, 1.12]]
        stream.log(
            f"{ROOT}/surface/names",
            rr.Points3D(ends, labels=list(self.labels), colors=colours, radii=0.008, show_labels=True),
            static=True,
        )


def _round_up(value: float) -> float:
    if not value > 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(
        next(step * power for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if step * power >= value * 0.999)
    )


def _surface(stream: rr.RecordingStream, found: RestoringForceResult, cube: Cube) -> None:
    vertices, triangles = figures.mesh(found)
    placed = np.clip(cube.place(*vertices.T), -1.2, 1.2)
    stream.log(
        f"{ROOT}/surface/fit",
        rr.Mesh3D(
            vertex_positions=placed,
            triangle_indices=triangles,
            vertex_colors=_colours(placed[:, 2]),
            face_rendering="DoubleSided",
        ),
        static=True,
    )
    stream.log(
        f"{ROOT}/surface/fit/numbers",
        rr.AnyValues(
            displacement=found.grid_displacement,
            velocity=found.grid_velocity,
            surface=found.surface.ravel(),
            visited=found.visited.ravel(),
        ),
        static=True,
    )


def _colours(height: Array) -> Array:
    import matplotlib

    table = matplotlib.colormaps["viridis"]((np.clip(height, -1, 1) + 1) / 2)
    colours: Array = (table * 255).astype(np.uint8)
    return colours


def tab(result: Identification) -> rrb.Container:
    """Return the layout of the tab."""
    if result.restoring_force is None:
        return rrb.Vertical(log.document("Restoring force", f"{ROOT}/refusal"), name="Restoring force")
    surface = rrb.Spatial3DView(
        origin=f"{ROOT}/surface",
        name="Restoring force surface (points: measured)",
        line_grid=False,
        eye_controls=rrb.EyeControls3D(
            position=(-1.55, -2.9, 1.55), look_target=(0.08, 0.0, -0.1), eye_up=(0.0, 0.0, 1.0)
        ),
    )
    return rrb.Horizontal(
        surface,
        rrb.Vertical(
            log.shown_picture("Sections", f"{ROOT}/sections"),
            log.shown_picture("Error against order, and significance of the terms", f"{ROOT}/orders"),
        ),
        column_shares=[1, 1.05],
        name="Restoring force",
    )
