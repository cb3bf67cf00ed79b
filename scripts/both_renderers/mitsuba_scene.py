"""A scene as Mitsuba's."""

import os

import numpy as np

from . import coat, compensated  # noqa: F401 (they register what materials name)
from .colours import rgb
from .lights import lamp
from .materials import bsdf, numbers
from .mitsuba_variant import mi
from .obj import read_obj


def write_ply(path, part, obj):
    """The part as a PLY file; whether it has normals."""
    corners = [c for triangle in part.triangles for c in triangle]
    unique = {c: i for i, c in enumerate(dict.fromkeys(corners))}
    textured, smooth = corners[0][1] is not None, corners[0][2] is not None
    mesh = mi.Mesh(
        "part", len(unique), len(part.triangles), has_vertex_normals=smooth, has_vertex_texcoords=textured
    )
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = obj.positions[[p for p, _, _ in unique]].astype(np.float32).ravel()
    if textured:
        # Textures' first row is at v = 1 in OBJ, at v = 0 in Mitsuba.
        of_vertices = obj.uvs[[uv for _, uv, _ in unique]] * [1.0, -1.0] + [0.0, 1.0]
        parameters["vertex_texcoords"] = of_vertices.astype(np.float32).ravel()
    if smooth:
        of_vertices = obj.normals[[n for _, _, n in unique]]
        of_vertices /= np.linalg.norm(of_vertices, axis=1, keepdims=True)
        parameters["vertex_normals"] = of_vertices.astype(np.float32).ravel()
    parameters["faces"] = np.array([unique[c] for c in corners], dtype=np.uint32)
    parameters.update()
    mesh.write_ply(path)
    return smooth


def shape(path, part, obj):
    """A part as Mitsuba's shape. Lamps emit around the geometric normal in Tamis, so they get no others here."""
    entry = obj.materials.get(part.material, {})
    smooth = write_ply(path, part, obj)
    emission = numbers(entry, "ke", np.zeros(3))
    described = {"type": "ply", "filename": path, "face_normals": not smooth or bool(emission.any())}
    described["bsdf"] = bsdf(part.material, entry, obj.folder)
    if emission.any():
        described["emitter"] = {"type": "area", "radiance": rgb(emission)}
    return described


def mitsuba_scene(view, folder):
    """The scene, loaded; `folder` takes its meshes."""
    obj = read_obj(view.scene)
    described = {"type": "scene", "sensor": sensor(view)}
    described["integrator"] = {"type": "path", "max_depth": view.max_depth + 1, "rr_depth": 100000}
    if view.environment:
        described["sky"] = {"type": "envmap", "filename": view.environment}
    described |= {f"light{i}": lamp(light) for i, light in enumerate(view.lights)}
    for i, part in enumerate(obj.parts):
        described[f"part{i}"] = shape(os.path.join(folder, f"part{i}.ply"), part, obj)
    return mi.load_dict(described)


def sensor(view):
    width, height = view.size
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "component_format": "float32"}
    film["rfilter"] = {"type": "box"}
    described = {
        "type": "perspective",
        "fov": view.fov,
        "fov_axis": "y",
        "near_clip": 1e-3,
        "to_world": mi.ScalarTransform4f().look_at(origin=view.eye, target=view.look_at, up=view.up),
        "film": film,
        "sampler": {"type": "independent"},
    }
    if view.lens_radius > 0.0:
        described |= {"type": "thinlens", "aperture_radius": view.lens_radius, "focus_distance": view.focus_distance}
    return described
