"""glTF files, read back by the loader of three.js in a browser."""

import base64
import json
import struct
import sys

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.problems import pendulum
from ancfsparse.results import export
from ancfsparse.results.export.report.web_page import FOLDER
from tests.results.report.browser import open_page

PAGE = """<!DOCTYPE html><meta charset="utf-8">
<script type="text/plain" id="library">{library}</script>
<script type="text/plain" id="model">{model}</script>
<script type="module">
const text = (id) => document.getElementById(id).textContent;
const bytes = (id) => Uint8Array.from(atob(text(id)), (c) => c.charCodeAt(0));
window.loaded = (async () => {{
  const address = URL.createObjectURL(new Blob([bytes("library")], {{ type: "text/javascript" }}));
  const {{ THREE, GLTFLoader }} = await import(address);
  const model = await new GLTFLoader().parseAsync(bytes("model").buffer, "");
  const mixer = new THREE.AnimationMixer(model.scene), clip = model.animations[0];
  mixer.clipAction(clip).play();
  const named = (name) => model.scene.getObjectByName(THREE.PropertyBinding.sanitizeNodeName(name));
  window.move = (t) => {{ mixer.setTime(t); model.scene.updateMatrixWorld(true); }};
  window.vertices = (name) => {{
    const mesh = named(name), out = [], p = new THREE.Vector3();
    for (let i = 0; i < mesh.geometry.attributes.position.count; i++)
      out.push(...mesh.getVertexPosition(i, p).applyMatrix4(mesh.matrixWorld).toArray());
    return out;
  }};
  window.matrix = (name) => named(name).matrixWorld.elements;
  return [clip.duration, clip.tracks.length];
}})();
</script>"""


def encode(data):
    return base64.b64encode(data).decode("ascii")


def open_model(path, folder):
    """Open a page that loads a model."""
    page = path.with_suffix(".html")
    library = (FOLDER / "three.js").read_text(encoding="utf-8").partition("//# sourceMapping")[0]
    page.write_text(
        PAGE.format(library=encode(library.encode()), model=encode(path.read_bytes())),
        encoding="utf-8",
    )
    return open_page(page, folder)


def swing(element="thin"):
    """A cable in space that swings, with a box on a rope below its end, and a ball."""
    scene = ancf.Scene((0, 0, -9.81))
    material = ancf.Circle(0.02), ancf.Material(1e7, 1e3)
    rod = scene.add_beam(element, (0, 0, 0), (1, 0, 0), 4, *material)
    scene.pin(rod.start)
    box = scene.add_body(
        ancf.Box(length=0.3, width=0.2, height=0.1), mass=0.2, position=(1, 0, -0.4),
        angular_velocity=(1, 2, 20),
    )  # fmt: skip
    scene.rope([rod.end, box.origin], stiffness=100.0)
    scene.contact(rod, ancf.Ball((0.5, 0, -1.5), 0.3), radius=0.01, stiffness=1e4)
    return ancf.simulate(scene, 0.4, 2e-3), rod, box


def upright(points):
    """Return points with z upwards as glTF has them, with y upwards."""
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


@pytest.mark.parametrize("element", ["thin", "string"])
def test_a_browser_shows_the_positions_of_the_run(tmp_path, element):
    pytest.importorskip("pygltflib")
    run, rod, box = swing(element)
    path = run.to_gltf(tmp_path / "run.glb")
    with open_model(path, tmp_path / "profile") as page:
        duration, tracks = page.run("loaded")
        assert duration == pytest.approx(0.4)
        assert tracks > 10
        for row in (0, 60, 133, 200):
            page.run(f"move({float(run.t[row])!r})")
            rings = np.array(page.run("vertices('beam 0')")).reshape(-1, 12, 3)
            centres = rings.mean(axis=1)
            # The rings of each element in order, then those of both ends.
            n = (len(rings) - 2) // 4
            s = (np.arange(4)[:, None] + np.linspace(0, 1, n)) * rod.length / 4
            exact = np.array([run.position(rod.at(x))[row] for x in s.ravel()])
            assert np.abs(centres[:-2] - upright(exact)).max() < 2e-7
            assert np.abs(centres[-2:] - upright(exact[[0, -1]])).max() < 2e-7
            radii = np.linalg.norm(rings[:-2] - centres[:-2, None], axis=2)
            assert radii.max() == pytest.approx(0.01, rel=1e-5)
            assert radii.min() > 0.0095
            matrix = np.array(page.run("matrix('body 1')")).reshape(4, 4)
            assert np.abs(matrix[3, :3] - upright(run.position(box.origin)[row])).max() < 2e-7
            corner = run.position(box.at((0.15, 0.1, 0.05)))[row]
            shown = np.array([0.15, 0.1, 0.05, 1.0]) @ matrix
            assert np.abs(shown[:3] - upright(corner)).max() < 3e-7
            ends = np.array([run.position(each)[row] for each in (rod.end, box.origin)])
            rope = np.array(page.run("vertices('rope 0')")).reshape(-1, 12, 3).mean(axis=1)
            assert np.abs(rope[:2] - upright(ends)).max() < 3e-7
        ball = np.array(page.run("vertices('ball')")).reshape(-1, 3)
        assert 0.5 * (ball.min(axis=0) + ball.max(axis=0)) == pytest.approx(
            [0.5, -1.5, 0], abs=1e-6
        )
        assert [each["type"] for each in page.messages if each.get("type") == "error"] == []


def contents_of(path):
    """Return the JSON part of a file, and the bytes of its tables."""
    data = path.read_bytes()
    magic, version, length, size, kind = struct.unpack("<4sIII4s", data[:20])
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def test_planar_runs_have_y_upwards_and_times_from_zero(tmp_path):
    pytest.importorskip("pygltflib")
    scene, rod = pendulum(n_elements=3)
    run = ancf.simulate(scene, 0.1, 1e-3)
    later = run.resample(np.linspace(0.05, 0.1, 6))
    model, data = contents_of(later.to_gltf(tmp_path / "run.glb"))
    assert model["nodes"][0]["rotation"] == [0, 0, 0, 1]

    def read(number):
        accessor = model["accessors"][number]
        view = model["bufferViews"][accessor["bufferView"]]
        start = view["byteOffset"]
        table = np.frombuffer(data[start : start + view["byteLength"]], "<f4")
        return table.reshape(accessor["count"], -1)

    (animation,) = model["animations"]
    moves = {
        (model["nodes"].index(model["nodes"][each["target"]["node"]]), each["target"]["path"]):
        animation["samplers"][each["sampler"]]
        for each in animation["channels"]
    }  # fmt: skip
    times = {each["input"] for each in animation["samplers"]}
    assert len(times) == 1
    assert read(times.pop()).ravel() == pytest.approx(np.linspace(0, 0.05, 6), abs=1e-8)
    paths = [read(each["output"]) for (_, path), each in moves.items() if path == "translation"]
    assert len(paths) == 4  # one joint for each node
    tip = max(paths, key=lambda path: path[0, 0])
    assert np.array_equal(tip[:, :2], later.position(rod.end).astype(np.float32))
    assert not tip[:, 2].any()
    for (_, path), each in moves.items():
        if path == "rotation":
            assert np.linalg.norm(read(each["output"]), axis=1) == pytest.approx(1.0, abs=1e-6)


def test_what_cannot_be_written_is_refused(tmp_path, monkeypatch):
    run = ancf.simulate(pendulum(n_elements=2).scene, 0.002, 1e-3)
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "pygltflib", None)
        for module in ("gltf", "gltf_file"):  # another test may have loaded them
            patch.delitem(sys.modules, f"ancfsparse.results.export.{module}", raising=False)
        patch.delitem(vars(export), "write_gltf", raising=False)
        with pytest.raises(InputError, match=r"pip install 'ancfsparse\[gltf\]', or take run.to_v"):
            run.to_gltf(tmp_path / "a.glb")
    pytest.importorskip("pygltflib")
    with pytest.raises(InputError, match=r"a glTF file must end in \.glb, got 'a.gltf'"):
        run.to_gltf("a.gltf")
    with pytest.raises(InputError, match="there is no folder no"):
        run.to_gltf("no/a.glb")
