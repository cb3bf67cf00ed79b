#!/usr/bin/env python3
"""Writes the OBJ and MTL files of this folder's scenes beside itself.

study: a room with a glossy table, glass and a small bright lamp.
halves: smooth ground under an even sky on the left, a dark niche with a tiny lamp and shiny balls on the right.
dusk/: a lawn with pinwheels, balls and bulbs, in pieces that dusk.toml moves.

Plain Python, no packages. Run it again after changing a shape: python3 scenes/make_scenes.py
"""
from math import cos, pi, sin, sqrt
from pathlib import Path

HERE = Path(__file__).resolve().parent

STUDY_MATERIALS = """\
newmtl wall
Kd 0.72 0.68 0.60
newmtl terracotta
Kd 0.58 0.24 0.15
newmtl ceiling
Kd 0.80 0.80 0.78
newmtl plank_light
Kd 0.42 0.28 0.17
Ks 0.04 0.04 0.04
Ns 60
newmtl plank_dark
Kd 0.33 0.21 0.12
Ks 0.04 0.04 0.04
Ns 60
newmtl table
Kd 0.16 0.07 0.04
Ks 0.06 0.06 0.06
Ns 300
newmtl brass
Kd 0 0 0
Ks 0.88 0.70 0.36
Pm 1
Pr 0.35
illum 3
newmtl steel
Kd 0 0 0
Ks 0.78 0.79 0.81
Pm 1
Pr 0.25
illum 3
newmtl glass
Kd 0 0 0
Ks 1 1 1
Tf 1 1 1
Ni 1.5
d 0.1
illum 7
newmtl ceramic
Kd 0.12 0.28 0.42
Ks 0.05 0.05 0.05
Ns 400
newmtl shade
Kd 0.70 0.64 0.50
newmtl book_red
Kd 0.50 0.08 0.07
newmtl book_ochre
Kd 0.60 0.42 0.10
newmtl book_green
Kd 0.10 0.30 0.16
newmtl paper
Kd 0.80 0.76 0.66
newmtl frame
Kd 0.05 0.05 0.05
newmtl lamp
Kd 0 0 0
Ke 900 760 560
newmtl skylight
Kd 0 0 0
Ke 9 10.5 12.5
"""

HALVES_MATERIALS = """\
newmtl chalk
Kd 0.55 0.55 0.55
newmtl sand
Kd 0.60 0.48 0.30
newmtl slate
Kd 0.45 0.47 0.50
newmtl steel
Kd 0 0 0
Ks 0.78 0.79 0.81
Pm 1
Pr 0.3
illum 3
newmtl gold
Kd 0 0 0
Ks 0.95 0.75 0.35
Pm 1
Pr 0.45
illum 3
newmtl glass
Kd 0 0 0
Tf 1 1 1
Ni 1.5
d 0.1
illum 7
newmtl lamp
Kd 0 0 0
Ke 900 850 700
"""

DUSK_MATERIALS = """\
newmtl lawn
Kd 0.16 0.24 0.10
newmtl wood
Kd 0.45 0.32 0.20
newmtl red
Kd 0.75 0.10 0.07
Ks 0.04 0.04 0.04
Pr 0.4
newmtl white
Kd 0.80 0.78 0.74
Ks 0.04 0.04 0.04
Pr 0.4
newmtl blue
Kd 0.07 0.22 0.60
Ks 0.04 0.04 0.04
Pr 0.4
newmtl yellow
Kd 0.80 0.55 0.06
Ks 0.04 0.04 0.04
Pr 0.4
newmtl brass
Kd 0.95 0.75 0.35
Pm 1
Pr 0.4
newmtl bulb
Kd 0 0 0
Ke 9 4.5 1.4
"""


class Mesh:
    """Collects vertices, normals and faces, and prints them as OBJ."""

    def __init__(self, library):
        self.lines = ["# made by make_scenes.py", f"mtllib {library}.mtl"]
        self.vertices = self.normals = 0

    def begin(self, name, material):
        self.lines += [f"o {name}", f"usemtl {material}"]

    def quad(self, a, b, c, d):
        """Counter-clockwise as seen from outside."""
        for p in (a, b, c, d):
            self.lines.append("v %.4g %.4g %.4g" % tuple(p))
        n = self.vertices
        self.lines.append(f"f {n + 1} {n + 2} {n + 3} {n + 4}")
        self.vertices += 4

    def box(self, low, high):
        (x0, y0, z0), (x1, y1, z1) = low, high
        self.quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1))
        self.quad((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0))
        self.quad((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1))
        self.quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0))
        self.quad((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0))
        self.quad((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1))

    def lathe(self, centre, profile, segments, materials=None):
        """Turns a profile of (radius, height) about the vertical axis; the outside is right of its direction.

        Of several materials, each gets as many segments in a row.
        """
        cx, cy, cz = centre
        rings = []
        for i, (r, h) in enumerate(profile):
            (r0, h0), (r1, h1) = profile[max(i - 1, 0)], profile[min(i + 1, len(profile) - 1)]
            nr, nh = h1 - h0, r0 - r1
            length = sqrt(nr * nr + nh * nh) or 1
            nr, nh = nr / length, nh / length
            ring = []
            for s in range(segments):
                a = 2 * pi * s / segments
                self.lines.append("v %.4g %.4g %.4g" % (cx + r * cos(a), cy + h, cz + r * sin(a)))
                self.lines.append("vn %.3g %.3g %.3g" % (nr * cos(a), nh, nr * sin(a)))
                self.vertices += 1
                self.normals += 1
                ring.append(f"{self.vertices}//{self.normals}")
            rings.append(ring)
        each = segments // len(materials or [0])
        for i in range(0, segments, each):
            self.lines += [f"usemtl {materials[i // each]}"] if materials else []
            for low, high in zip(rings, rings[1:]):
                for s in range(i, i + each):
                    t = (s + 1) % segments
                    self.lines.append(f"f {low[s]} {high[s]} {high[t]} {low[t]}")


def sphere(radius, steps):
    """Profile of a sphere, from its bottom to its top."""
    angles = [pi * i / steps - pi / 2 for i in range(steps + 1)]
    return [(max(radius * cos(a), 1e-5), radius * sin(a)) for a in angles]


def room(m):
    m.begin("floor_light", "plank_light")
    planks = [(-2.0 + 0.2 * i, -1.8 + 0.2 * i) for i in range(20)]
    for x0, x1 in planks[0::2]:
        m.quad((x0, 0, 2.4), (x1, 0, 2.4), (x1, 0, -2), (x0, 0, -2))
    m.begin("floor_dark", "plank_dark")
    for x0, x1 in planks[1::2]:
        m.quad((x0, 0, 2.4), (x1, 0, 2.4), (x1, 0, -2), (x0, 0, -2))
    m.begin("ceiling", "ceiling")
    m.quad((-2, 2.6, -2), (2, 2.6, -2), (2, 2.6, 2.4), (-2, 2.6, 2.4))
    m.begin("back", "wall")
    m.quad((-2, 0, -2), (2, 0, -2), (2, 2.6, -2), (-2, 2.6, -2))
    m.begin("right", "wall")
    m.quad((2, 0, -2), (2, 0, 2.4), (2, 2.6, 2.4), (2, 2.6, -2))
    m.begin("front", "wall")
    m.quad((2, 0, 2.4), (-2, 0, 2.4), (-2, 2.6, 2.4), (2, 2.6, 2.4))
    m.begin("left", "terracotta")
    m.quad((-2, 0, 2.4), (-2, 0, -2), (-2, 2.6, -2), (-2, 2.6, 2.4))
    m.begin("skylight", "skylight")
    m.quad((0.9, 2.59, 1.9), (0.9, 2.59, 0.6), (1.8, 2.59, 0.6), (1.8, 2.59, 1.9))


def furniture(m):
    m.begin("table_top", "table")
    m.box((-0.85, 0.71, -1.45), (0.85, 0.75, -0.45))
    m.begin("table_legs", "table")
    for x in (-0.8, 0.74):
        for z in (-1.4, -0.56):
            m.box((x, 0, z), (x + 0.06, 0.71, z + 0.06))
    m.begin("picture_frame", "frame")
    m.box((-0.65, 1.35, -2), (0.15, 1.95, -1.97))
    m.begin("picture", "paper")
    m.quad((-0.6, 1.4, -1.969), (0.1, 1.4, -1.969), (0.1, 1.9, -1.969), (-0.6, 1.9, -1.969))
    m.begin("picture_sun", "book_ochre")
    m.quad((-0.2, 1.62, -1.968), (0.02, 1.62, -1.968), (0.02, 1.82, -1.968), (-0.2, 1.82, -1.968))
    m.begin("picture_hill", "book_green")
    m.quad((-0.6, 1.4, -1.968), (0.1, 1.4, -1.968), (0.1, 1.52, -1.968), (-0.6, 1.6, -1.968))
    m.begin("book_low", "book_green")
    m.box((-0.72, 0.75, -1.25), (-0.38, 0.79, -0.99))
    m.begin("book_middle", "book_ochre")
    m.box((-0.70, 0.79, -1.23), (-0.40, 0.82, -1.01))
    m.begin("book_high", "book_red")
    m.box((-0.69, 0.82, -1.21), (-0.43, 0.865, -1.03))


def things(m):
    m.begin("lamp_foot", "brass")
    m.lathe((0.5, 0.75, -1.1), [(0.001, 0), (0.09, 0), (0.09, 0.012), (0.012, 0.02), (0.008, 0.2), (0.008, 0.36)], 24)
    m.begin("lamp_bulb", "lamp")
    m.lathe((0.5, 1.14, -1.1), [(0.06, 0), (0.001, 0)], 16)
    m.begin("lamp_shade", "shade")
    m.lathe((0.5, 1.08, -1.1), [(0.165, 0), (0.09, 0.19)], 32)
    m.begin("goblet", "glass")
    outside = [(0.001, 0), (0.036, 0), (0.036, 0.004), (0.008, 0.01), (0.005, 0.03), (0.005, 0.075), (0.012, 0.085),
               (0.034, 0.1), (0.044, 0.125), (0.044, 0.15), (0.038, 0.19)]
    inside = [(0.0355, 0.19), (0.0415, 0.15), (0.0415, 0.125), (0.032, 0.103), (0.01, 0.092), (0.001, 0.09)]
    m.lathe((0.02, 0.75, -0.72), outside + inside, 32)
    m.begin("paperweight", "glass")
    m.lathe((-0.28, 0.805, -0.72), sphere(0.055, 14), 28)
    m.begin("ball", "steel")
    m.lathe((0.22, 0.83, -0.93), sphere(0.08, 14), 28)
    m.begin("bowl", "ceramic")
    m.lathe((-0.12, 0.75, -1.12), [(0.001, 0), (0.05, 0), (0.055, 0.01), (0.11, 0.05), (0.14, 0.1), (0.132, 0.1),
                                   (0.104, 0.056), (0.05, 0.018), (0.001, 0.014)], 32)


def study():
    mesh = Mesh("study")
    room(mesh)
    furniture(mesh)
    things(mesh)
    return mesh


def halves():
    m = Mesh("halves")
    m.begin("ground", "chalk")
    m.quad((-6, 0, 4), (6, 0, 4), (6, 0, -2), (-6, 0, -2))
    m.begin("backdrop", "chalk")
    m.quad((-6, 0, -2), (6, 0, -2), (6, 6, -2), (-6, 6, -2))
    m.begin("ball_large", "sand")
    m.lathe((-1.2, 0.5, -0.6), sphere(0.5, 20), 40)
    m.begin("niche_left", "slate")
    m.box((0.0, 0, -1.2), (0.1, 1.9, 0.6))
    m.begin("niche_right", "slate")
    m.box((1.9, 0, -1.2), (2.0, 1.9, 0.6))
    m.begin("niche_top", "slate")
    m.box((0.0, 1.9, -1.2), (2.0, 2.0, 0.6))
    m.begin("niche_back", "slate")
    m.box((0.0, 0, -1.3), (2.0, 2.0, -1.2))
    m.begin("niche_lamp", "lamp")
    m.quad((0.96, 1.7, -0.36), (0.96, 1.7, -0.28), (1.04, 1.7, -0.28), (1.04, 1.7, -0.36))
    for i, (x, y, z, material) in enumerate([
            (0.45, 0.2, -0.3, "steel"), (1.0, 0.2, -0.6, "gold"), (1.5, 0.2, -0.2, "glass"), (0.75, 0.2, 0.2, "glass"),
            (1.25, 0.2, 0.25, "steel"), (1.0, 0.54, -0.35, "gold")]):
        m.begin(f"niche_ball_{i}", material)
        m.lathe((x, y, z), sphere(0.2, 12), 24)
    return m


def lawn(m):
    m.begin("lawn", "lawn")
    m.quad((-40, 0, 8), (40, 0, 8), (40, 0, -40), (-40, 0, -40))
    m.begin("sticks", "wood")
    for x, y, z in [(-0.95, 1.35, 0), (0.75, 1.25, -2.6), (-4.3, 1.1, -6)]:
        m.box((x - 0.025, 0, z - 0.14), (x + 0.025, y, z - 0.09))


def pinwheel(m):
    for i in range(6):
        m.begin(f"vane_{i}", ["red", "yellow", "blue"][i % 3])
        corners = [(0, 0, 0), (0.75, 0, -0.02), (0.62, 0.55, 0.16), (0.1, 1, 0.03)]
        m.quad(*((r * cos(pi * (i + t) / 3), r * sin(pi * (i + t) / 3), z) for r, t, z in corners))
    m.begin("hub", "white")
    m.box((-0.05, -0.05, -0.1), (0.05, 0.05, 0.08))


def beach_ball(m):
    m.begin("beach_ball", "red")
    m.lathe((0, 0, 0), sphere(0.45, 16), 30, ["red", "white", "yellow", "white", "blue", "white"])


def marble(m):
    m.begin("marble", "brass")
    m.lathe((0, 0, 0), sphere(0.16, 12), 24)


def bulb(m):
    m.begin("bulb", "bulb")
    m.lathe((0, 0, 0), sphere(0.05, 5), 10)


def main():
    for name, mesh, materials in [("study", study(), STUDY_MATERIALS), ("halves", halves(), HALVES_MATERIALS)]:
        write(name, mesh)
        (HERE / f"{name}.mtl").write_text(materials)
    for piece in (lawn, pinwheel, beach_ball, marble, bulb):
        mesh = Mesh("dusk")
        piece(mesh)
        write(f"dusk/{piece.__name__}", mesh)
    (HERE / "dusk" / "dusk.mtl").write_text(DUSK_MATERIALS)


def write(name, mesh):
    (HERE / f"{name}.obj").write_text("\n".join(mesh.lines) + "\n")


if __name__ == "__main__":
    main()
