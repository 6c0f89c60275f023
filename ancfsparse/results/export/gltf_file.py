"""Contents of a glTF file: tables of numbers, meshes, nodes and their motions, by pygltflib."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError

try:
    import pygltflib as gltf
except ImportError as missing:
    raise InputError(
        "a glTF file needs pygltflib, which is not installed: pip install 'ancfsparse[gltf]', "
        "or take run.to_vtk()"
    ) from missing

KINDS = {1: gltf.SCALAR, 3: gltf.VEC3, 4: gltf.VEC4, 16: gltf.MAT4}
COMPONENTS = {"f4": gltf.FLOAT, "u2": gltf.UNSIGNED_SHORT, "u4": gltf.UNSIGNED_INT}
ROUGHNESS = 0.6
MAX_JOINTS = 65535  # of a mesh, whose numbers have 16 bits


class GltfFile:
    """A file with one scene and one animation.

    Parameters
    ----------
    t : ndarray, shape (k,)
        Times of the animation [s].
    """

    def __init__(self, t: Vector) -> None:
        self._model = gltf.GLTF2(asset=gltf.Asset(version="2.0", generator="ancfsparse"))
        self._parts: list[bytes] = []
        self._size = 0
        self._animation = gltf.Animation(name="run")
        self._times = self._add_table(t[:, None] - t[0], "f4", limits=True)

    def add_material(self, name: str, colour: tuple[float, float, float]) -> int:
        """Add a material with a colour in linear RGB, and return its number."""
        surface = gltf.PbrMetallicRoughness(
            baseColorFactor=[*colour, 1.0], metallicFactor=0.0, roughnessFactor=ROUGHNESS
        )
        material = gltf.Material(name=name, pbrMetallicRoughness=surface, doubleSided=True)
        self._model.materials.append(material)
        return len(self._model.materials) - 1

    def add_mesh(
        self,
        material: int,
        points: Vector,
        indices: NDArray[np.integer[Any]],
        **attributes: NDArray[Any],
    ) -> int:
        """Add a mesh of triangles (n, 3) or lines (n, 2), and return its number.

        Attributes of its points have the names of the format; numbers of joints are integers.
        """
        tables = {"POSITION": self._add_table(points, "f4", gltf.ARRAY_BUFFER, limits=True)}
        for name, values in attributes.items():
            form = "u2" if name == "JOINTS_0" else "f4"
            tables[name] = self._add_table(values, form, gltf.ARRAY_BUFFER)
        corners = self._add_table(indices.reshape(-1, 1), "u4", gltf.ELEMENT_ARRAY_BUFFER)
        primitive = gltf.Primitive(
            attributes=gltf.Attributes(**tables), indices=corners, material=material,
            mode=gltf.TRIANGLES if indices.shape[1] == 3 else gltf.LINES,
        )  # fmt: skip
        self._model.meshes.append(gltf.Mesh(primitives=[primitive]))
        return len(self._model.meshes) - 1

    def add_node(self, parent: int | None = None, **values: Any) -> int:
        """Add a node, and return its number; without a parent it belongs to the scene."""
        number = len(self._model.nodes)
        self._model.nodes.append(gltf.Node(**values))
        if parent is None:
            self._model.scenes = self._model.scenes or [gltf.Scene()]
            self._model.scenes[0].nodes.append(number)
        else:
            self._model.nodes[parent].children.append(number)
        return number

    def move(self, node: int, path: str, values: Vector) -> None:
        """Let a node have translations, rotations (x, y, z, w) or scales (k, 3 or 4)."""
        table = self._add_table(values, "f4")
        target = gltf.AnimationChannelTarget(node=node, path=path)
        number = len(self._animation.samplers)
        sampler = gltf.AnimationSampler(
            input=self._times, output=table, interpolation=gltf.ANIM_LINEAR
        )
        self._animation.samplers.append(sampler)
        self._animation.channels.append(gltf.AnimationChannel(sampler=number, target=target))

    def add_skin(self, joints: list[int], root: int) -> int:
        """Add a skin whose joints are all at the origin where its mesh is at rest."""
        if len(joints) > MAX_JOINTS:
            raise InputError(
                f"a glTF file has at most {MAX_JOINTS} joints in a mesh, and a body needs "
                f"{len(joints)}: take run.to_vtk()"
            )
        inverse = self._add_table(np.tile(np.eye(4).ravel(), (len(joints), 1)), "f4")
        self._model.skins.append(
            gltf.Skin(inverseBindMatrices=inverse, joints=joints, skeleton=root)
        )
        return len(self._model.skins) - 1

    def write(self, target: Path) -> None:
        """Write the file."""
        data = b"".join(self._parts)
        self._model.scene = 0
        if self._animation.channels:
            self._model.animations.append(self._animation)
        self._model.buffers.append(gltf.Buffer(byteLength=len(data)))
        self._model.set_binary_blob(data)
        try:
            self._model.save_binary(str(target))
        except OSError as error:
            raise InputError(f"{target} cannot be written: {error.strerror}") from error

    def _add_table(
        self, values: ArrayLike, form: str, target: int | None = None, *, limits: bool = False
    ) -> int:
        """Add a table, and return the number of its accessor."""
        table = np.ascontiguousarray(values, f"<{form}")
        data = table.tobytes()
        data += b"\0" * (-len(data) % 4)
        model = self._model
        model.bufferViews.append(
            gltf.BufferView(buffer=0, byteOffset=self._size, byteLength=len(data), target=target)
        )
        accessor = gltf.Accessor(
            bufferView=len(model.bufferViews) - 1, componentType=COMPONENTS[form],
            count=len(table), type=KINDS[table.shape[1]],
        )  # fmt: skip
        if limits:
            accessor.min, accessor.max = table.min(axis=0).tolist(), table.max(axis=0).tolist()
        model.accessors.append(accessor)
        self._parts.append(data)
        self._size += len(data)
        return len(model.accessors) - 1
