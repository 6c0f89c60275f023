// Draws the moving scene of the page with three.js, which the page contains; nothing is loaded from elsewhere.

const find = (id) => document.getElementById(id);

async function inflate(id) {
  const text = find(id).textContent.trim();
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

// ---- data ------------------------------------------------------------------------------------------------

// Tables of the page, see packing.py: numbers that move are second differences of 16 bits.
function readTables(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const contents = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const base = 4 + length;
  const tables = {};
  for (const [name, entry] of Object.entries(contents.tables)) {
    const size = entry.shape.reduce((a, b) => a * b, 1);
    tables[name] = entry.step === undefined
      ? { shape: entry.shape, values: new Float32Array(buffer, base + entry.start, size) }
      : { shape: entry.shape, values: integrate(buffer, base + entry.start, entry) };
  }
  return [contents, tables];
}

function integrate(buffer, start, { shape: [rows, columns], low, step }) {
  const size = rows * columns;
  const small = new Uint8Array(buffer, start, size), large = new Uint8Array(buffer, start + size, size);
  const values = new Float32Array(size);
  for (let c = 0, i = 0; c < columns; c++) {
    let rate = 0, level = 0;
    for (let t = 0; t < rows; t++, i++) {
      rate = (rate + small[i] + 256 * large[i]) & 65535;
      level = (level + rate) & 65535;
      values[t * columns + c] = low + step * level;
    }
  }
  return values;
}

// ---- drawing -----------------------------------------------------------------------------------------------

const VERTEX = `
precision highp sampler2D;
uniform sampler2D points, tints;  // positions, and colours of the elements
uniform float pixel;   // size of a pixel at distance 1
uniform vec3 rope, solid;
uniform bool ribbon;    // two vertices of a ring, which turn to the viewer
in float point, before, after, element, radius, cap, angle;
out vec3 facing, tint;
out float across;      // of a flat tube, -1 to 1
vec3 fetch(sampler2D table, float number) {
  int k = int(number);
  return texelFetch(table, ivec2(k & 1023, k >> 10), 0).xyz;
}
void main() {
  vec3 centre = fetch(points, point), along = fetch(points, after) - fetch(points, before);
  float stretch = dot(along, along);
  along = stretch > 0.0 ? along * inversesqrt(stretch) : vec3(1, 0, 0);
  // The rotation that takes a fixed direction d to the axis turns its normals u and w with it; it is singular at -d.
  const vec3 d = vec3(0.5388, -0.6285, 0.5609), u = vec3(-0.7592, -0.6509, 0.0), w = vec3(0.3651, -0.4258, -0.8279);
  vec3 normal = cos(angle) * u + sin(angle) * w, sum = d + along;
  normal -= sum * (dot(along, normal) / max(1.0 + dot(d, along), 1e-6));
  across = ribbon ? cos(angle) : 0.0;
  if (ribbon) normal = across * normalize(cross(along, cameraPosition - centre) + 1e-9 * normal);
  vec4 seen = modelViewMatrix * vec4(centre, 1.0);
  float thick = element == -1.0 ? 0.7 : 1.3;  // least radius in pixels, of ropes and springs, and of bodies
  float size = cap == 0.0 ? max(radius, thick * pixel * -seen.z) : 0.0;
  vec3 side = normalMatrix * normal;
  facing = cap == 0.0 ? side : normalMatrix * (cap * along);
  tint = element >= 0.0 ? fetch(tints, element) : element == -1.0 ? rope : solid;
  gl_Position = projectionMatrix * (seen + vec4(size * side, 0.0));
}`;

const FRAGMENT = `
in vec3 facing, tint;
in float across;
uniform bool ribbon;
out vec4 colour;
void main() {
  // The normals at the edges of a flat tube are opposite to each other; between them it is round.
  vec3 n = ribbon ? facing + vec3(0, 0, sqrt(max(1.0 - across * across, 0.0))) : normalize(facing);
  float light = 0.55 + 0.45 * max(dot(n, normalize(vec3(0.35, 0.55, 0.75))), 0.0);
  colour = vec4(tint * light + 0.12 * pow(max(n.z, 0.0), 24.0), 1.0);
}`;

const FORCES = { load: 0xc0392b, reaction: 0x3b7d4f };
const RULER = 120;  // pixels, the longest length that is shown
const WIDTH = 1024;  // texels of a row of a table, as in the shader
const PLAIN = [47, 111, 159], SOLID = 0xe3a35c, ROPE = 0x666666;  // colours of beams, rigid bodies, and ropes
const MAX_TRIANGLES = { hardware: 480000, software: 15000 };  // of tubes, which get fewer sides, or are flat, above

class View {
  constructor(three, contents, tables, canvas, hardware) {
    Object.assign(this, { three, contents, tables, canvas, hardware });
    const { THREE, OrbitControls } = three;
    const context = canvas.getContext("webgl2", { alpha: false, antialias: hardware });
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;  // colours as they are given
    THREE.ColorManagement.enabled = false;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0xffffff);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb0b0b0, 2.0));
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.01, 1e4);
    this.light = new THREE.DirectionalLight(0xffffff, 1.6);
    this.scene.add(this.light);
    this.controls = new OrbitControls(this.camera, canvas);
    this.updates = [];
    this.addTubes();
    contents.solids.forEach((solid, k) => this.addSolid(solid, k));
    this.addObstacles();
    this.addSupports();
    this.addArrows();
    this.lookAtAll();
  }

  texture(count, format, channels) {
    const { THREE } = this.three;
    const width = WIDTH, height = Math.ceil(Math.max(count, 1) / width);
    const data = new Float32Array(width * height * channels);
    return new THREE.DataTexture(data, width, height, format, THREE.FloatType);
  }

  addTubes() {
    const { THREE } = this.three, { tables, contents } = this;
    const rings = tables.rings, strips = tables.strips, count = rings.shape[0];
    if (!count) return;
    const most = MAX_TRIANGLES[this.hardware ? "hardware" : "software"] / (2 * strips.shape[0]);
    const ribbon = most < 4, sides = ribbon ? 2 : Math.min(12, Math.floor(most));
    const geometry = new THREE.BufferGeometry();
    ["point", "before", "after", "element", "radius", "cap"].forEach((name, column) => {
      const values = new Float32Array(count * sides);
      for (let i = 0; i < values.length; i++) values[i] = rings.values[6 * Math.floor(i / sides) + column];
      geometry.setAttribute(name, new THREE.BufferAttribute(values, 1));
    });
    const angles = new Float32Array(count * sides);
    for (let i = 0; i < angles.length; i++) angles[i] = 2 * Math.PI * (i % sides) / sides;
    geometry.setAttribute("angle", new THREE.BufferAttribute(angles, 1));
    const quads = ribbon ? 1 : sides, index = new Uint32Array(6 * quads * strips.shape[0]);
    for (let s = 0, i = 0; s < strips.shape[0]; s++) {
      const a = strips.values[2 * s] * sides, b = strips.values[2 * s + 1] * sides;
      for (let k = 0; k < quads; k++) {
        const next = (k + 1) % sides;
        index.set([a + k, b + next, b + k, a + k, a + next, b + next], i);
        i += 6;
      }
    }
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    const points = this.texture(tables.x.shape[1], THREE.RGBAFormat, 4);
    const tints = this.texture(contents.elements, THREE.RGBAFormat, 4);
    this.uniforms = {
      points: { value: points }, tints: { value: tints }, pixel: { value: 0 }, ribbon: { value: ribbon },
      rope: { value: new THREE.Color(ROPE) }, solid: { value: new THREE.Color(SOLID) },
    };
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: this.uniforms,
      glslVersion: THREE.GLSL3, side: ribbon ? THREE.DoubleSide : THREE.FrontSide,
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    this.updates.push((frame) => {
      const n = tables.x.shape[1];
      for (const [c, name] of ["x", "y", "z"].slice(0, contents.dim).entries()) {
        const row = tables[name].values;
        for (let p = 0, i = frame * n; p < n; p++, i++) points.image.data[4 * p + c] = row[i];
      }
      points.needsUpdate = true;
      this.tint(tints.image.data, frame);
      tints.needsUpdate = true;
    });
  }

  // Fills the table of the colours of elements, plain or between the colours of a scale.
  tint(data, frame) {
    const { contents, tables, quantity } = this, n = contents.elements, scale = contents.colours;
    const row = quantity ? tables[quantity].values.subarray(frame * n, (frame + 1) * n) : null;
    const [low, high] = this.limits || [0, 1], last = row ? scale.length - 1 : 0;
    for (let e = 0; e < n; e++) {
      const level = row ? last * Math.min(Math.max((row[e] - low) / (high - low || 1), 0), 1) : 0;
      const k = Math.min(Math.floor(level), last - 1), share = level - k;
      for (let c = 0; c < 3; c++) {
        data[4 * e + c] = (row ? (1 - share) * scale[k][c] + share * scale[k + 1][c] : PLAIN[c]) / 255;
      }
    }
  }

  addSolid(solid, k) {
    const { THREE } = this.three, { tables, contents } = this;
    const group = new THREE.Group();
    group.matrixAutoUpdate = false;
    const points = new THREE.BufferAttribute(tables[`points ${k}`].values, 3);
    const facets = Uint32Array.from(tables[`facets ${k}`].values), edges = Uint32Array.from(tables[`edges ${k}`].values);
    if (facets.length) {
      const corners = new THREE.BufferGeometry();
      corners.setAttribute("position", points);
      corners.setIndex(new THREE.BufferAttribute(facets, 1));
      const surface = new THREE.MeshLambertMaterial({
        color: SOLID, side: THREE.DoubleSide, flatShading: true, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
      });
      group.add(new THREE.Mesh(corners.toNonIndexed(), surface));
    }
    const lines = new THREE.BufferGeometry();
    lines.setAttribute("position", points);
    lines.setIndex(new THREE.BufferAttribute(edges, 1));
    group.add(new THREE.LineSegments(lines, new THREE.LineBasicMaterial({ color: 0x6b4a22 })));
    group.traverse((each) => { each.frustumCulled = false; });
    this.scene.add(group);
    const dim = contents.dim, m = solid.axes, origin = tables[`origin ${k}`].values, axes = tables[`axes ${k}`].values;
    this.updates.push((frame) => {
      const e = group.matrix.elements;
      for (let v = 0; v < 3; v++) {
        for (let c = 0; c < 3; c++) {
          e[4 * v + c] = v < m ? (c < dim ? axes[(frame * m + v) * dim + c] : 0) : v === c && dim === 2 ? 1 : 0;
        }
      }
      for (let c = 0; c < dim; c++) e[12 + c] = origin[frame * dim + c];
      group.matrixWorldNeedsUpdate = true;
    });
  }

  addObstacles() {
    const { THREE } = this.three, lines = new THREE.BufferGeometry();
    if (!this.tables.obstacles.shape[0]) return;
    lines.setAttribute("position", new THREE.BufferAttribute(this.tables.obstacles.values, 3));
    this.scene.add(new THREE.LineSegments(lines, new THREE.LineBasicMaterial({ color: 0xb4b4b4 })));
  }

  addSupports() {
    const { THREE } = this.three, table = this.tables.supports, dim = this.contents.dim;
    const shown = this.contents.supports.flatMap((kind, k) => ["force", "moment"].includes(kind) ? [] : [k]);
    if (!shown.length) return;
    const position = new THREE.BufferAttribute(new Float32Array(3 * shown.length), 3);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", position);
    const material = new THREE.PointsMaterial({ color: 0x333333, size: 6, sizeAttenuation: false, depthTest: false });
    const marks = new THREE.Points(geometry, material);
    marks.frustumCulled = false;
    this.scene.add(marks);
    this.updates.push((frame) => {
      shown.forEach((k, i) => {
        for (let c = 0; c < dim; c++) position.array[3 * i + c] = table.values[frame * table.shape[1] + k * dim + c];
      });
      position.needsUpdate = true;
    });
  }

  // Arrows that begin at their points; the longest has a length of a fifth of the box.
  addArrows() {
    const { THREE } = this.three, { contents, tables } = this, { arrows, box, dim } = contents;
    const size = Math.hypot(...box[1].map((high, c) => high - box[0][c])), thick = 0.004 * size;
    this.forces = new THREE.Group();
    this.scene.add(this.forces);
    if (!arrows.length) return;
    const shaft = new THREE.CylinderGeometry(1, 1, 0.75, 12).translate(0, 0.375, 0);
    const head = new THREE.ConeGeometry(2.6, 0.25, 16).translate(0, 0.875, 0);
    const groups = arrows.map((kind) => {
      const material = new THREE.MeshLambertMaterial({ color: FORCES[kind] }), group = new THREE.Group();
      group.add(new THREE.Mesh(shaft, material), new THREE.Mesh(head, material));
      this.forces.add(group);
      return group;
    });
    const points = tables["arrow points"].values, forces = tables["arrow forces"].values, n = arrows.length * dim;
    const force = new THREE.Vector3(), above = new THREE.Vector3(0, 1, 0);
    this.updates.push((frame) => {
      groups.forEach((group, k) => {
        force.set(0, 0, 0);
        for (let c = 0; c < dim; c++) {
          force.setComponent(c, forces[frame * n + k * dim + c]);
          group.position.setComponent(c, points[frame * n + k * dim + c]);
        }
        const length = 0.2 * size * force.length() / contents.force;
        group.visible = length > thick;
        group.scale.set(thick, length, thick);
        group.quaternion.setFromUnitVectors(above, force.normalize());
      });
    });
  }

  lookAtAll() {
    const { THREE } = this.three, { box, dim, up } = this.contents;
    const low = new THREE.Vector3(...box[0]), high = new THREE.Vector3(...box[1]);
    const centre = low.clone().add(high).multiplyScalar(0.5);
    const axis = new THREE.Vector3().setComponent(up, 1);
    const direction = new THREE.Vector3();
    if (dim === 2) direction.set(0, 0, 1);
    else {
      const tilt = 22 * Math.PI / 180, turn = -60 * Math.PI / 180;
      direction.setComponent((up + 1) % 3, Math.cos(tilt) * Math.cos(turn));
      direction.setComponent((up + 2) % 3, Math.cos(tilt) * Math.sin(turn));
      direction.setComponent(up, Math.sin(tilt));
    }
    this.camera.up.copy(axis);
    this.resize();
    const half = Math.tan(this.camera.fov * Math.PI / 360);
    const right = new THREE.Vector3().crossVectors(axis, direction).normalize();
    const above = new THREE.Vector3().crossVectors(direction, right);
    let distance = 0;
    for (let corner = 0; corner < 8; corner++) {  // the box fits into the picture
      const p = new THREE.Vector3(...[0, 1, 2].map((c) => box[corner >> c & 1][c])).sub(centre);
      const across = Math.max(Math.abs(p.dot(right)) / this.camera.aspect, Math.abs(p.dot(above)));
      distance = Math.max(distance, p.dot(direction) + across / half);
    }
    this.camera.near = distance / 100;
    this.camera.far = distance * 100;
    this.camera.position.copy(centre).addScaledVector(direction, distance);
    this.controls.target.copy(centre);
    this.controls.update();
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.drawScale();
    if (this.uniforms) this.uniforms.pixel.value = 2 * Math.tan(this.camera.fov * Math.PI / 360) / height;
  }

  colourBy(name) {
    this.quantity = name;
    if (!name) return null;
    const { low, step } = this.contents.tables[name];
    this.limits = [low, low + 65535 * step];
    return this.limits;
  }

  // The middle of a body, which the camera can follow.
  middle(name, frame) {
    const { THREE } = this.three, { contents, tables } = this, out = new THREE.Vector3();
    const body = contents.bodies.find((each) => each.name === name);
    const k = contents.solids.findIndex((each) => each.name === name);
    for (let c = 0; c < contents.dim; c++) {
      let sum = 0;
      if (body) {
        const table = tables["xyz"[c]], n = table.shape[1];
        for (let p = body.first; p < body.end; p++) sum += table.values[frame * n + p];
        sum /= body.end - body.first;
      } else sum = tables[`origin ${k}`].values[frame * contents.dim + c];
      out.setComponent(c, sum);
    }
    return out;
  }

  follow(name, frame) {
    this.followed = name || null;
    if (name) this.last = this.middle(name, frame);
  }

  show(frame) {
    for (const update of this.updates) update(frame);
    if (this.followed) {
      const now = this.middle(this.followed, frame), step = now.clone().sub(this.last);
      this.camera.position.add(step);
      this.controls.target.add(step);
      this.last = now;
    }
    this.draw();
  }

  draw() {
    this.controls.update();
    this.light.position.copy(this.camera.position).add(this.camera.up);
    this.renderer.render(this.scene, this.camera);
  }

  // A length at the distance of the centre of the view, and the directions of the axes.
  drawScale() {
    const { THREE } = this.three, { camera, contents } = this;
    const distance = camera.position.distanceTo(this.controls.target);
    const metre = this.canvas.clientHeight / (2 * distance * Math.tan(camera.fov * Math.PI / 360));  // pixels
    const exact = RULER / metre, power = 10 ** Math.floor(Math.log10(exact));
    const length = power * [5, 2, 1].find((each) => each * power <= exact);
    find("ruler").style.width = `${length * metre}px`;
    find("length").textContent = `${format(length)} m`;
    find("axis-z").parentElement.classList.toggle("flat", contents.dim === 2);
    const back = camera.quaternion.clone().invert();
    for (const [c, name] of ["x", "y", "z"].slice(0, contents.dim).entries()) {
      const way = new THREE.Vector3().setComponent(c, 1).applyQuaternion(back);
      const line = find(`axis-${name}`), label = find(`name-${name}`);
      line.setAttribute("x2", 24 * way.x);
      line.setAttribute("y2", -24 * way.y);
      label.setAttribute("x", 32 * way.x);
      label.setAttribute("y", -32 * way.y);
    }
  }
}

// ---- time --------------------------------------------------------------------------------------------------

const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
const LONGEST = 12;  // s, of a film at the chosen speed

class Player {
  constructor(view, times) {
    Object.assign(this, { view, times, frame: 0, playing: false, drawn: 0 });
    this.slider = find("slider");
    this.slider.max = times.length - 1;
    this.slider.addEventListener("input", () => { this.pause(); this.show(Number(this.slider.value)); });
    find("play").addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    const span = times[times.length - 1] - times[0], speed = find("speed");
    const chosen = SPEEDS.find((each) => span / each <= LONGEST) || SPEEDS[SPEEDS.length - 1];
    for (const each of SPEEDS) speed.add(new Option(`\u00d7 ${each}`, each, each === chosen, each === chosen));
    speed.addEventListener("change", () => { if (this.playing) this.play(); });
    this.cursors = [...document.querySelectorAll("[data-axis]")].map(makeCursor);
    if (times.length < 2) for (const each of [find("play"), find("slider"), find("time"), speed.parentElement]) each.hidden = true;
    this.show(0);
  }

  show(frame) {
    this.frame = frame;
    this.slider.value = frame;
    find("time").textContent = `t = ${format(this.times[frame])} s`;
    for (const move of this.cursors) move(this.times[frame]);
    this.view.show(frame);
    this.drawn++;
  }

  play() {
    const { times } = this, first = times[0], span = times[times.length - 1] - first;
    this.playing = true;
    find("play").textContent = "Pause";
    const from = this.frame === times.length - 1 ? 0 : times[this.frame] - first, begin = performance.now();
    const run = this.run = (now) => {
      if (!this.playing || this.run !== run) return;
      const passed = (from + 1e-3 * (now - begin) * Number(find("speed").value)) % (span * 1.0001);
      this.show(this.row(first + passed));
      requestAnimationFrame(run);
    };
    requestAnimationFrame(run);
  }

  pause() {
    this.playing = false;
    find("play").textContent = "Play";
  }

  row(time) {  // the last state before or at a time
    let low = 0, high = this.times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= time) low = middle; else high = middle - 1;
    }
    return low;
  }
}

// Four digits; zero for what is a rounding error of a scale.
function format(number, scale = 0) {
  return Math.abs(number) < 1e-6 * Math.abs(scale) ? "0" : String(Number(number.toPrecision(4)));
}

// A line at the present time in a graph over time, whose axes are given as left, right, top, bottom, first and last time.
function makeCursor(figure) {
  const [left, right, top, bottom, first, last] = figure.dataset.axis.split(" ").map(Number);
  const { width, height } = figure.querySelector("svg").viewBox.baseVal, cursor = document.createElement("div");
  cursor.className = "cursor";
  cursor.style.top = `${100 * top / height}%`;
  cursor.style.height = `${100 * (bottom - top) / height}%`;
  figure.append(cursor);
  let scale = 1;
  new ResizeObserver(() => { scale = figure.clientWidth / width; }).observe(figure);
  return (time) => {  // without a new layout of the page
    const x = left + (right - left) * (time - first) / (last - first);
    cursor.style.transform = `translateX(${scale * x}px)`;
  };
}

// ---- simulations -------------------------------------------------------------------------------------------

// Shows the frames that a simulation sends: their time, and the numbers of the tables that move, in single precision.
function followSimulation({ view, player, contents, tables }, recolour) {
  const source = new EventSource("frames");
  let moved = false;
  view.controls.addEventListener("start", () => { moved = true; });
  find("reset").addEventListener("click", () => { moved = false; });
  find("time").hidden = false;
  source.addEventListener("message", ({ data }) => {
    const [time, text] = data.split(" ");
    const values = new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
    let start = 1;
    for (const [name, size] of contents.live) {
      const part = values.subarray(start, start + size), entry = contents.tables[name];
      tables[name].values.set(part);
      if (contents.quantities.some((each) => each.name === name)) {  // the limits of all frames so far
        const high = part.reduce((a, b) => Math.max(a, b), entry.low + 65535 * entry.step);
        entry.low = part.reduce((a, b) => Math.min(a, b), entry.low);
        entry.step = (high - entry.low) / 65535;
      }
      start += size;
    }
    contents.t[0] = Number(time);
    if (grow(contents, tables) && !moved) view.lookAtAll();
    recolour();
  });
  source.addEventListener("end", () => source.close());
}

// Enlarges the box of the scene if it does not contain its points; true if it grew.
function grow({ box, dim, solids }, tables) {
  let grown = false;
  const size = Math.max(...box[0].map((low, c) => box[1][c] - low));
  const include = (c, value) => {
    if (value < box[0][c]) { box[0][c] = value - 0.2 * size; grown = true; }
    if (value > box[1][c]) { box[1][c] = value + 0.2 * size; grown = true; }
  };
  for (let c = 0; c < dim; c++) {
    for (const value of tables["xyz"[c]].values) include(c, value);
    solids.forEach((_, k) => include(c, tables[`origin ${k}`].values[c]));
  }
  return grown;
}

// ---- start -------------------------------------------------------------------------------------------------

// Without WebGL a sentence is shown; software that draws without a graphics card gets no smoothed edges.
function probe() {
  if (typeof DecompressionStream === "undefined") return null;
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return null;
  const info = context.getExtension("WEBGL_debug_renderer_info");
  const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return { hardware: !/swiftshader|llvmpipe|software/i.test(name) };
}

async function start() {
  const ability = probe();
  if (!ability) {
    find("stage").classList.add("missing");
    return null;
  }
  const [library, data] = await Promise.all([inflate("library"), inflate("data")]);
  const address = URL.createObjectURL(new Blob([library], { type: "text/javascript" }));
  const three = await import(address);
  URL.revokeObjectURL(address);
  const [contents, tables] = readTables(data);
  const view = new View(three, contents, tables, find("canvas"), ability.hardware);
  const player = new Player(view, contents.t);
  const colour = find("colour"), follow = find("follow");
  for (const each of contents.quantities) colour.add(new Option(each.label, each.name));
  for (const each of [...contents.bodies, ...contents.solids]) follow.add(new Option(each.name, each.name));
  const recolour = () => {
    const limits = view.colourBy(colour.value);
    find("bar").hidden = !limits;
    if (limits) [find("low").textContent, find("high").textContent] = limits.map((each) => format(each, limits[1] - limits[0]));
    player.show(player.frame);
  };
  if (contents.colours) find("scale").style.background = `linear-gradient(to right, ${contents.colours.map((c) => `rgb(${c})`)})`;
  colour.addEventListener("change", recolour);
  if (contents.quantities.length) colour.value = contents.quantities[0].name;
  else colour.parentElement.hidden = true;
  recolour();
  find("forces").parentElement.hidden = find("legend").hidden = !contents.arrows.length;
  if (contents.arrows.length) find("greatest").textContent = `, longest ${format(contents.force)} N`;
  find("forces").addEventListener("change", (event) => {
    view.forces.visible = event.target.checked;
    find("legend").hidden = !event.target.checked;
    view.draw();
  });
  follow.addEventListener("change", () => view.follow(follow.value, player.frame));
  find("reset").addEventListener("click", () => { view.lookAtAll(); view.draw(); });
  view.controls.addEventListener("change", () => {
    view.drawScale();
    if (!player.playing) view.renderer.render(view.scene, view.camera);
  });
  new ResizeObserver(() => { view.resize(); view.draw(); }).observe(find("stage"));
  const time = /^#t=([\d.e+-]+)$/.exec(location.hash);  // run.html#t=0.5 begins at 0.5 s
  if (time) player.show(player.row(Number(time[1])));
  const report = { view, player, contents, tables };
  if (contents.live) followSimulation(report, recolour);
  return report;
}

window.report = start();
