"""Draws a height map, its facets, naive rays, the hemispherical tally and the BRDF lobe of a table.

    visual_check.py MAP.npy TABLE.npz PICTURE.png      (pitches 0.5 and 0.6 um)

Nothing here uses code of asperity: the map and the table are read as NumPy arrays, facets are reflected and rays are
traced again from their definitions, and the energies found in both ways must agree.
"""

import json
import sys

import numpy as np
import pyvista as pv
from PIL import Image

PITCH = np.array([0.5e-6, 0.6e-6])
THETA_I, PHI_I = np.radians(45.0), np.radians(210.0)
WI = np.array([np.sin(THETA_I) * np.cos(PHI_I), np.sin(THETA_I) * np.sin(PHI_I), np.cos(THETA_I)])
UM = 1e6
INK, SOFT = "#222222", "#777777"


def vertices(heights):
    """Row 0 is the top row: x grows with the column, y shrinks with the row."""
    rows, columns = heights.shape
    y, x = np.mgrid[rows - 1 : -1 : -1, :columns]
    return np.stack([x * PITCH[0], y * PITCH[1], heights], axis=-1)


def facets(heights):
    """Two triangles a cell, along the diagonal from (row, column) to the one below and to the right; normals up."""
    v = vertices(heights)
    a, b, c, d = v[:-1, :-1], v[:-1, 1:], v[1:, :-1], v[1:, 1:]
    triangles = np.concatenate([np.stack([a, d, b], 2).reshape(-1, 3, 3), np.stack([a, c, d], 2).reshape(-1, 3, 3)])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return triangles, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def reflected(incoming, normals):
    """Both directions leave the surface."""
    return 2 * (normals @ incoming)[:, None] * normals - incoming


def tally(normals, steps):
    """Share of the energy that single reflections send into each patch of equal polar and azimuthal angle."""
    weight = np.maximum(normals @ WI, 0) / normals[:, 2]
    out = reflected(WI, normals)
    up = out[:, 2] > 0
    theta, phi = np.arccos(np.clip(out[:, 2], -1, 1)), np.arctan2(out[:, 1], out[:, 0]) % (2 * np.pi)
    edges = np.linspace(0, np.pi / 2, steps + 1), np.linspace(0, 2 * np.pi, 4 * steps + 1)
    energy, _, _ = np.histogram2d(theta[up], phi[up], bins=edges, weights=weight[up])
    return energy / weight.sum(), edges


class Table:
    """The native file, at one of its incident directions."""

    def __init__(self, path):
        file = np.load(path)
        self.header = json.loads(bytes(file["header_json"]))
        self.centre, self.width = file["slope_centre"], file["slope_cell_width"]
        self.angle = np.radians(file["axis_angle_deg"][0])
        self.axes = file["cells_per_axis"].astype(int)
        node = (
            np.abs(file["theta_i_deg"] - np.degrees(THETA_I)).argmin(),
            np.abs(file["phi_i_deg"] - np.degrees(PHI_I)).argmin() if len(file["phi_i_deg"]) > 1 else 0,
        )
        self.albedo = file["albedo"][node]
        self.masking = file["masking"]
        self.density = file["density"][node].reshape(2 * self.axes[1, 2] + 1, 2 * self.axes[0, 2] + 1)

    def coordinate(self, x, axis):
        core, per_octave, half = self.axes[axis]
        inner, distance = core + 0.5, np.abs(x)
        y = 1 + np.maximum(distance - inner, 0) / per_octave
        e = np.floor(np.log2(y))
        u = np.copysign(np.minimum(distance, inner) + per_octave * (e + y / 2**e - 1), x)
        return np.clip(u + half, 0, 2 * half - 1e-9)

    def f_r(self, wo):
        """Torrance and Sparrow's relation for a mirror with Smith's masking, density bilinear between the cell centres."""
        wh = wo + WI
        wh = wh / np.linalg.norm(wh, axis=-1, keepdims=True)
        p, q = -wh[..., 0] / wh[..., 2] - self.centre[0], -wh[..., 1] / wh[..., 2] - self.centre[1]
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        u = self.coordinate((cos * p + sin * q) / self.width[0], 0)
        v = self.coordinate((cos * q - sin * p) / self.width[1], 1)
        i, j = u.astype(int), v.astype(int)
        s, t = u - i, v - j
        d = self.density
        t_wh = (1 - t) * ((1 - s) * d[j, i] + s * d[j, i + 1]) + t * ((1 - s) * d[j + 1, i] + s * d[j + 1, i + 1])
        cosines = np.linspace(0, 1, len(self.masking))
        cos_o = np.maximum(wo[..., 2], 1e-6)
        hidden = [np.interp(c, cosines, self.masking) / c for c in (WI[2], cos_o)]
        return t_wh / (1 + hidden[0] + hidden[1]) / (4 * WI[2] * cos_o * wh[..., 2] ** 4)


def directions(theta, phi):
    theta, phi = np.broadcast_arrays(theta, phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def hits(triangles, origin, direction):
    """Distance to the first facet and its number, all facets tried (Moeller and Trumbore 1997); none: -1."""
    a, ab, ac = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    h = np.cross(direction, ac)
    determinant = np.einsum("ij,ij->i", ab, h)
    with np.errstate(divide="ignore", invalid="ignore"):
        f = 1 / determinant
        s = origin - a
        u = f * np.einsum("ij,ij->i", s, h)
        g = np.cross(s, ab)
        v = f * (g @ direction)
        distance = f * np.einsum("ij,ij->i", ac, g)
    fits = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 1e-10)
    if not fits.any():
        return np.inf, -1
    distance = np.where(fits, distance, np.inf)
    return distance.min(), distance.argmin()


def traced(triangles, normals, corner, count):
    """Paths of rays that come down evenly over the mean plane: lists of points, one per bounce."""
    rng = np.random.default_rng(3)
    paths = []
    for x, y in rng.uniform(0.12, 0.88, (count, 2)) * corner:
        origin = np.array([x, y, 0]) + 14e-6 * WI
        path, direction = [origin], -WI
        for _ in range(4):
            distance, facet = hits(triangles, path[-1], direction)
            if facet < 0:
                break
            path.append(path[-1] + distance * direction)
            direction = direction - 2 * (direction @ normals[facet]) * normals[facet]
        if len(path) > 1:
            paths.append(path + [path[-1] + 9e-6 * direction])
    return paths


def arrow(plotter, tip, colour, end=0.0):
    start, way = (tip, end * tip - tip)
    plotter.add_mesh(pv.Arrow(start=start, direction=way, tip_length=0.12, tip_radius=0.025, shaft_radius=0.008, scale="auto"), color=colour)


def surface_mesh(heights):
    v = vertices(heights) * UM
    return pv.StructuredGrid(v[..., 0], v[..., 1], v[..., 2]), v[..., 2]


def bar(title, fmt):
    """A colour bar in the upper right; the empty line keeps its title off the topmost number."""
    return {"title": title + "\n ", "fmt": fmt, "color": INK, "title_font_size": 15, "label_font_size": 13, "n_labels": 4, "vertical": True,
            "height": 0.36, "width": 0.06, "position_x": 0.88, "position_y": 0.54}


def title(plotter, text, note):
    plotter.add_text(text, position=(0.03, 0.93), viewport=True, font_size=11, color=INK)
    plotter.add_text(note, position=(0.03, 0.035), viewport=True, font_size=8, color=SOFT)


def main(map_path, table_path, picture):
    heights = np.load(map_path)
    heights = heights - heights.mean()
    triangles, normals = facets(heights)
    table = Table(table_path)
    steps = 30
    energy, (theta_edges, phi_edges) = tally(normals, steps)
    solid = np.diff(-np.cos(theta_edges))[:, None] * np.diff(phi_edges)[None, :]

    # The energy of the table, integrated by the midpoint rule, against its own albedo and against the facets.
    theta, phi = (np.arange(360) + 0.5) * np.pi / 720, (np.arange(1440) + 0.5) * np.pi / 720
    grid = directions(theta[:, None], phi[None, :])
    lobe = table.f_r(grid)
    whole = (lobe * np.cos(theta)[:, None] * np.sin(theta)[:, None]).sum() * (np.pi / 720) ** 2
    mean = lambda e: (directions(0.5 * (theta_edges[:-1] + theta_edges[1:])[:, None], 0.5 * (phi_edges[:-1] + phi_edges[1:])[None, :]) * e[..., None]).sum((0, 1)) / e.sum()
    binned = (lobe * np.cos(theta)[:, None] * np.sin(theta)[:, None]).reshape(steps, 360 // steps, 4 * steps, -1).sum((1, 3))
    apart = 0.5 * np.abs(binned / binned.sum() - energy / energy.sum()).sum()
    turned = np.degrees(np.arccos(np.clip(mean(binned) @ mean(energy) / np.linalg.norm(mean(binned)) / np.linalg.norm(mean(energy)), -1, 1)))
    print(f"energy {whole:.4f} of the table's lobe, albedo {table.albedo:.4f} in its file, {energy.sum():.4f} of single reflections")
    print(f"lobe and facets: mean directions {turned:.2f} deg apart, {100 * apart:.1f} % of the energy in other patches")

    pv.global_theme.font.family = "arial"
    plotter = pv.Plotter(shape=(2, 2), off_screen=True, window_size=(1500, 1240), border=False)
    plotter.set_background("white")

    # The corner at the top left of the map, true to scale.
    plotter.subplot(0, 0)
    corner = heights[:13, :15]
    mesh, z = surface_mesh(corner)
    plotter.add_mesh(mesh, scalars=z.ravel(order="F"), cmap="viridis", show_edges=True, edge_color="#5a6a70", line_width=0.8,
                     scalar_bar_args=bar("height / um", "%.2f"))
    own, own_normals = facets(corner)
    centres = own.mean(axis=1) * UM
    plotter.add_arrows(centres, own_normals, mag=0.5, color="#b3321c")
    plotter.camera_position = [(14, -9.5, 8.5), (3.6, 3.4, 0.2), (0, 0, 1)]
    plotter.camera.zoom(1.05)
    title(plotter, "Facets and their normals", "top left corner of the map, 14 x 12 cells, true to scale")

    plotter.subplot(0, 1)
    corner = heights[:21, :25]
    own, own_normals = facets(corner)
    mesh, z = surface_mesh(corner)
    plotter.add_mesh(mesh, color="#b9c6cc", show_edges=True, edge_color="#94a3a8", line_width=0.5)
    paths = traced(own, own_normals, np.array([24 * PITCH[0], 20 * PITCH[1]]), 70)
    for path in paths:
        points = np.array(path) * UM
        for k in range(len(points) - 1):
            last, first = k == len(points) - 2, k == 0
            colour = "#e0a100" if first else "#0b6fb3" if last and len(points) == 3 else "#c2185b"
            plotter.add_mesh(pv.Line(points[k], points[k + 1]), color=colour, line_width=1.6)
    plotter.camera_position = [(28, -24, 17), (6.0, 6.5, 4.2), (0, 0, 1)]
    more = sum(len(p) > 3 for p in paths)
    count = f"{len(paths)} rays from theta_i 45, phi_i 210 deg (yellow), reflected once (blue)"
    title(plotter, "Naive rays", count + (f", {more} more than once (red)" if more else ""))

    plotter.subplot(1, 0)
    radiance = energy / solid
    t, f = np.meshgrid(theta_edges, phi_edges, indexing="ij")
    dome = directions(t, f)
    shell = pv.StructuredGrid(dome[..., 0], dome[..., 1], dome[..., 2])
    shell.cell_data["energy per sr"] = np.where(radiance > 0, radiance, np.nan).ravel(order="F")
    colours = {"cmap": "plasma_r", "log_scale": True, "clim": (1e-2, radiance.max())}
    plotter.add_mesh(shell, scalars="energy per sr", nan_color="#f2f2f2", show_edges=True, edge_color="#cfcfcf", line_width=0.3,
                     lighting=False, **colours, scalar_bar_args=bar("energy / sr", "%.2g"))
    arrow(plotter, 1.55 * WI, "#e0a100", end=0.66)
    mirror = WI * [-1, -1, 1]
    plotter.add_mesh(pv.Line(mirror, 1.3 * mirror), color=INK, line_width=3)
    view = [(-0.2, -3.2, 4.1), (0.05, 0.0, 0.3), (0, 0, 1)]
    plotter.camera_position = view
    title(plotter, "Where the facets send the light", "single reflections, 3 deg patches; yellow: source, black: mirror direction")

    plotter.subplot(1, 1)
    # Times the cosine, as the patches count it: f_r itself grows without bound towards the horizon.
    shown = lobe * np.cos(theta)[:, None]
    shown = np.concatenate([shown, shown[:, :1]], axis=1)
    ball = np.concatenate([grid, grid[:, :1]], axis=1) * np.sqrt(shown / shown.max())[..., None]
    shape = pv.StructuredGrid(ball[..., 0], ball[..., 1], ball[..., 2])
    plotter.add_mesh(shape, scalars=np.maximum(shown, 1e-9).ravel(order="F"), smooth_shading=True, specular=0.2, lighting=True,
                     **colours, scalar_bar_args=bar("f_r cos / (1/sr)", "%.2g"))
    plotter.add_mesh(pv.Disc(outer=1.0, inner=0.0, c_res=90), color="#e8ecee", opacity=0.7)
    plotter.add_mesh(pv.Line((0, 0, 0), (1.0, 0, 0)), color=SOFT, line_width=2)
    plotter.add_point_labels([(1.05, 0, 0)], ["x"], show_points=False, shape=None, font_size=14, text_color=SOFT)
    arrow(plotter, 1.25 * WI, "#e0a100")
    plotter.add_mesh(pv.Line((0, 0, 0), 1.25 * mirror), color=INK, line_width=3)
    plotter.camera_position = view
    title(plotter, "Lobe of the table", f"radius: root of f_r cos theta_r; energy {whole:.4f}, albedo {table.albedo:.4f}; means {turned:.2f} deg apart")

    # Drawn larger than shown, which smooths the lines; 256 colours keep the file small.
    shot = Image.fromarray(plotter.screenshot(None, return_img=True)).resize((1200, 992), Image.Resampling.LANCZOS)
    shot.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG).save(picture, optimize=True)
    print(f"picture: {picture}")
    if not (abs(whole - table.albedo) < 0.01 and turned < 1.0 and apart < 0.05):
        sys.exit("the lobe of the table is not where the facets send the light")


if __name__ == "__main__":
    main(*sys.argv[1:])
