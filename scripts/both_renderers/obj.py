"""Geometry of OBJ files and statements of MTL files."""

import dataclasses
import os

import numpy as np


def statements(path):
    """Key and words of each statement; comments and continued lines resolved."""
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read().replace("\\\n", " ")
    for line in text.splitlines():
        words = line.split("#", 1)[0].split()
        if words:
            yield words[0], words[1:]


def read_mtl(path):
    """Statements of each material, by name and lower-case key."""
    materials = {}
    for key, words in statements(path):
        if key.lower() == "newmtl":
            entry = materials.setdefault(" ".join(words), {})
        elif materials:
            entry[key.lower()] = words
    return materials


@dataclasses.dataclass
class Part:
    """Triangles of one material: three (position, uv, normal) triples of indices each, None for what there is not."""

    material: str
    triangles: list = dataclasses.field(default_factory=list)


@dataclasses.dataclass
class Obj:
    """What an OBJ file holds."""

    positions: np.ndarray
    uvs: np.ndarray
    normals: np.ndarray
    parts: list
    materials: dict
    folder: str


def read_obj(path):
    """Vertices, parts and materials of an OBJ file."""
    positions, uvs, normals, parts, materials, material = [], [], [], {}, {}, ""
    folder = os.path.dirname(path)
    for key, words in statements(path):
        if key == "v":
            positions.append([float(w) for w in words[:3]])
        elif key == "vt":
            uvs.append([float(w) for w in words[:2]])
        elif key == "vn":
            normals.append([float(w) for w in words[:3]])
        elif key == "mtllib":
            materials |= read_mtl(os.path.join(folder, " ".join(words)))
        elif key == "usemtl":
            material = " ".join(words)
        elif key == "f":
            corners = [corner(word, (len(positions), len(uvs), len(normals))) for word in words]
            known = tuple(all(c[kind] is not None for c in corners) for kind in (1, 2))
            part = parts.setdefault((material, known), Part(material))
            fan = zip(corners[1:], corners[2:])
            part.triangles += [(corners[0], b, c) for b, c in fan]
    arrays = (np.array(values) for values in (positions, uvs, normals))
    return Obj(*arrays, list(parts.values()), materials, folder)


def corner(word, counts):
    """Zero-based indices of position, uv and normal of a face's corner; negative ones count from the end."""
    fields = (word.split("/") + ["", ""])[:3]
    return tuple(index(int(f), n) if f else None for f, n in zip(fields, counts))


def index(number, count):
    return number - 1 if number > 0 else number + count
