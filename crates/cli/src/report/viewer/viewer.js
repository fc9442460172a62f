"use strict";
// A scene that turns: bodies in WebGL, overlaps in the colors of their depth, frames on a slider.
(() => {
  const stage = document.getElementById("stage");
  const canvas = stage.querySelector("canvas");
  const gl = canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
  if (!gl) return; // The pictures of the page remain.

  const model = JSON.parse(document.getElementById("model").textContent);
  const blob = Uint8Array.from(atob(document.getElementById("blob").textContent), (c) => c.charCodeAt(0)).buffer;
  const MAX_MAPS = 32;
  const [RAMP, UNIT] = [model.ramp, model.unit];

  // Shaders. Positions are 16-bit fractions of the scene's box; a vertex lies between two maps.
  const SHARED = `#version 300 es
    precision highp float;
    uniform mat4 camera; uniform vec3 origin, extent; uniform mat4 maps[${MAX_MAPS}];
    vec3 unpack(uvec4 a) { return origin + vec3(a.xyz) / 65535.0 * extent; }
  `;
  const BODY_VERTEX = `${SHARED}
    layout(location = 0) in uvec4 place; layout(location = 1) in vec3 normal; layout(location = 2) in float depth;
    out vec3 vNormal; out float vDepth;
    void main() {
      uint first = place.w >> 11u; float share = float(place.w & 2047u) / 2047.0;
      uint second = min(first + 1u, ${MAX_MAPS - 1}u);
      mat4 map = maps[first] * (1.0 - share) + maps[second] * share;
      gl_Position = camera * (map * vec4(unpack(place), 1.0));
      vNormal = mat3(map) * normal; vDepth = depth;
    }`;
  const PATCH_VERTEX = `${SHARED}
    layout(location = 0) in uvec4 place; out vec3 vNormal; out float vDepth;
    void main() {
      gl_Position = camera * vec4(unpack(place), 1.0);
      vNormal = vec3(0.0); vDepth = float(place.w) / 65535.0;
    }`;
  const FRAGMENT = `#version 300 es
    precision highp float;
    uniform vec3 color, eye; uniform float alpha; uniform int mode; uniform vec3 ramp[17];
    in vec3 vNormal; in float vDepth; out vec4 result;
    vec3 scale(float t) { float at = clamp(t, 0.0, 1.0) * 16.0; int i = min(int(at), 15); return mix(ramp[i], ramp[i + 1], at - float(i)); }
    void main() {
      if (mode == 1 && vDepth <= 0.0) discard;
      vec3 base = mode == 1 || vDepth > 0.0 ? scale(vDepth) : color;
      float light = length(vNormal) > 0.0 ? 0.35 + 0.65 * abs(dot(normalize(vNormal), eye)) : 1.0;
      result = vec4(base * (mode == 1 ? 1.0 : light), alpha);
    }`;

  function program(vertex, fragment) {
    const result = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(result, shader);
    }
    gl.linkProgram(result);
    if (!gl.getProgramParameter(result, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(result));
    const uniforms = {};
    for (const name of ["camera", "origin", "extent", "maps", "color", "eye", "alpha", "mode", "ramp"]) {
      uniforms[name] = gl.getUniformLocation(result, name);
    }
    return { result, uniforms };
  }
  const bodyProgram = program(BODY_VERTEX, FRAGMENT);
  const patchProgram = program(PATCH_VERTEX, FRAGMENT);

  function buffer(target, data) {
    const made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    return made;
  }

  // Bodies: arrays, vertex normals and depths.
  const bodies = model.bodies.map((body) => {
    const places = new Uint16Array(blob, body.vertices.at, 4 * body.vertices.count);
    const Corners = body.wide ? Uint32Array : Uint16Array;
    const corners = new Corners(blob, body.faces.at, 3 * body.faces.count);
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    buffer(gl.ARRAY_BUFFER, places);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribIPointer(0, 4, gl.UNSIGNED_SHORT, 0, 0);
    buffer(gl.ARRAY_BUFFER, normals(places, corners));
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 0, 0);
    const depths = new Float32Array(body.vertices.count);
    const depthBuffer = buffer(gl.ARRAY_BUFFER, depths);
    gl.enableVertexAttribArray(2);
    gl.vertexAttribPointer(2, 1, gl.FLOAT, false, 0, 0);
    buffer(gl.ELEMENT_ARRAY_BUFFER, corners);
    const type = body.wide ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT;
    return { ...body, vao, type, depths, depthBuffer, count: corners.length, shown: true };
  });

  function normals(places, corners) {
    const sums = new Float32Array((3 * places.length) / 4);
    const at = (v, k) => (places[4 * v + k] * model.extent[k]) / 65535;
    for (let f = 0; f < corners.length; f += 3) {
      const [a, b, c] = [corners[f], corners[f + 1], corners[f + 2]];
      const u = [0, 1, 2].map((k) => at(b, k) - at(a, k));
      const v = [0, 1, 2].map((k) => at(c, k) - at(a, k));
      const n = cross(u, v);
      for (const vertex of [a, b, c]) for (let k = 0; k < 3; k++) sums[3 * vertex + k] += n[k];
    }
    for (let v = 0; v < sums.length; v += 3) {
      const length = Math.hypot(sums[v], sums[v + 1], sums[v + 2]) || 1;
      for (let k = 0; k < 3; k++) sums[v + k] /= length;
    }
    return sums;
  }

  // Clipped parts of surfaces inside other bodies, one list per pair.
  const patches = model.patches.map((patch) => {
    const Corners = patch.wide ? Uint32Array : Uint16Array;
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    buffer(gl.ARRAY_BUFFER, new Uint16Array(blob, patch.vertices.at, 4 * patch.vertices.count));
    gl.enableVertexAttribArray(0);
    gl.vertexAttribIPointer(0, 4, gl.UNSIGNED_SHORT, 0, 0);
    buffer(gl.ELEMENT_ARRAY_BUFFER, new Corners(blob, patch.faces.at, 3 * patch.faces.count));
    const type = patch.wide ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT;
    return { vao, type, count: 3 * patch.faces.count, a: patch.a, b: patch.b };
  });
  gl.bindVertexArray(null);

  // Vectors, and column-major matrices.
  function cross(a, b) {
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  }
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const unit = (a) => a.map((x) => x / (Math.hypot(...a) || 1));

  // The camera turns about a point, upright along the scene's longest axis.
  const [lower, upper] = model.view;
  const center = lower.map((x, k) => (x + upper[k]) / 2);
  const up = [0, 0, 0];
  up[model.up] = 1;
  const radius = Math.hypot(...upper.map((x, k) => x - lower[k])) / 2;
  const FOCUS = 1 / Math.tan(0.35);
  const view = { yaw: 0.6, pitch: 0.15, target: center.slice(), distance: 0 };

  /** Looks at all bodies in all frames. */
  function fit() {
    view.target = center.slice();
    view.distance = 0;
    const aspect = canvas.clientWidth / canvas.clientHeight || 1;
    const { out, right, above } = basis();
    for (let corner = 0; corner < 8; corner++) {
      const at = center.map((x, k) => (corner & (1 << k) ? upper[k] : lower[k]) - x);
      const [x, y] = [Math.abs(dot(at, right)) / aspect, Math.abs(dot(at, above))];
      view.distance = Math.max(view.distance, dot(at, out) + 1.05 * FOCUS * Math.max(x, y));
    }
  }

  function basis() {
    const side = [0, 0, 0], front = [0, 0, 0];
    side[(model.up + 1) % 3] = 1;
    front[(model.up + 2) % 3] = 1;
    const flat = side.map((x, k) => Math.cos(view.yaw) * x + Math.sin(view.yaw) * front[k]);
    const out = flat.map((x, k) => Math.cos(view.pitch) * x + Math.sin(view.pitch) * up[k]);
    const right = unit(cross(up, out));
    return { out, right, above: cross(out, right) };
  }

  function cameraMatrix() {
    const { out, right, above } = basis();
    const eye = view.target.map((x, k) => x + view.distance * out[k]);
    const near = Math.max(view.distance - 2.5 * radius, view.distance / 200);
    const far = view.distance + 2.5 * radius;
    const f = FOCUS;
    const aspect = canvas.width / canvas.height;
    const rows = [
      [...right.map((x) => (f / aspect) * x), (-f / aspect) * dot(right, eye)],
      [...above.map((x) => f * x), -f * dot(above, eye)],
    ];
    const z = [...out.map((x) => -x), dot(out, eye)];
    const depth = z.map((x) => (x * (far + near)) / (far - near));
    depth[3] -= (2 * far * near) / (far - near);
    rows.push(depth, z);
    return { matrix: Float32Array.from({ length: 16 }, (_, i) => rows[i % 4][i >> 2]), out };
  }

  // State of the page.
  let frame = 0;
  let chosen = null; // Names of a pair.
  const chosenBody = (k) => chosen && (chosen.a === k || chosen.b === k);
  const held = new Map();

  function setFrame(number) {
    frame = Math.max(0, Math.min(model.frames.length - 1, number));
    const { depths } = model.frames[frame];
    if (depths) {
      bodies.forEach((body, k) => {
        body.depths.fill(0);
        const { at, count } = depths[k];
        const entries = new Uint16Array(blob, at, 3 * count);
        for (let i = 0; i < entries.length; i += 3) {
          body.depths[entries[i] + 65536 * entries[i + 1]] = entries[i + 2] / 65535;
        }
        gl.bindBuffer(gl.ARRAY_BUFFER, body.depthBuffer);
        gl.bufferSubData(gl.ARRAY_BUFFER, 0, body.depths);
      });
    }
    listPairs();
    drawTime();
    draw();
  }

  /** Returns the maps of a body in the frame, as column-major matrices. */
  function mapsOf(body) {
    const result = new Float32Array(16 * MAX_MAPS);
    const { maps } = model.frames[frame];
    const rows = maps ? new Float32Array(blob, maps.at, 12 * maps.count) : null;
    for (let slot = 0; slot < MAX_MAPS; slot++) {
      const number = body.maps[Math.min(slot, body.maps.length - 1)];
      for (let i = 0; i < 16; i++) {
        const [row, column] = [i % 4, i >> 2];
        const fixed = row === column ? 1 : 0;
        result[16 * slot + i] = rows && number !== undefined && number !== null && row < 3 ? rows[12 * number + 4 * row + column] : fixed;
      }
    }
    return result;
  }

  function useProgram({ result, uniforms }, matrix, out) {
    gl.useProgram(result);
    gl.uniformMatrix4fv(uniforms.camera, false, matrix);
    gl.uniform3fv(uniforms.origin, model.origin);
    gl.uniform3fv(uniforms.extent, model.extent);
    gl.uniform3fv(uniforms.ramp, RAMP.flat().map((x) => x / 255));
    gl.uniform3fv(uniforms.eye, out);
    return uniforms;
  }

  function draw() {
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth * scale, canvas.clientHeight * scale].map(Math.round);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    const { matrix, out } = cameraMatrix();

    const uniforms = useProgram(bodyProgram, matrix, out);
    const drawBody = (body, mode, alpha) => {
      gl.uniformMatrix4fv(uniforms.maps, false, mapsOf(body));
      gl.uniform3fv(uniforms.color, body.color.map((x) => x / 255));
      gl.uniform1i(uniforms.mode, mode);
      gl.uniform1f(uniforms.alpha, alpha);
      gl.bindVertexArray(body.vao);
      gl.drawElements(gl.TRIANGLES, body.count, body.type, 0);
    };
    const drawPatches = (alpha) => {
      const own = useProgram(patchProgram, matrix, out);
      gl.uniform1i(own.mode, 1);
      gl.uniform1f(own.alpha, alpha);
      for (const patch of patches) {
        const shown = bodies[patch.a].shown && bodies[patch.b].shown;
        if (!shown || (chosen && !(chosen.a === patch.a && chosen.b === patch.b))) continue;
        gl.bindVertexArray(patch.vao);
        gl.drawElements(gl.TRIANGLES, patch.count, patch.type, 0);
      }
    };

    // Solid bodies first, the pair alone where one is chosen; the others are glass.
    const solid = bodies.filter((body, k) => body.shown && (!chosen || chosenBody(k)));
    const glass = bodies.filter((body, k) => body.shown && chosen && !chosenBody(k));
    gl.disable(gl.BLEND);
    solid.forEach((body) => drawBody(body, 0, 1));
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(-1, -2);
    if (patches.length) drawPatches(1);
    gl.disable(gl.POLYGON_OFFSET_FILL);

    // Then what shines through: overlaps behind nearer surfaces, and glass.
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.disable(gl.DEPTH_TEST);
    if (patches.length) drawPatches(0.45);
    useProgram(bodyProgram, matrix, out);
    if (model.frames[frame].depths) solid.forEach((body) => drawBody(body, 1, 0.45));
    gl.enable(gl.DEPTH_TEST);
    glass.forEach((body) => drawBody(body, 0, 0.12));
    gl.bindVertexArray(null);
  }

  let asked = false;
  function redraw() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(); });
  }

  // Turning, moving and zooming.
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  for (const kind of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(kind, (event) => held.delete(event.pointerId));
  }
  canvas.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    held.set(event.pointerId, [event.clientX, event.clientY]);
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const spread = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      zoom(spread(before) / spread([event.clientX, event.clientY]));
    } else if (event.shiftKey || event.buttons === 2) {
      const { right, above } = basis();
      const step = (0.73 * view.distance) / canvas.clientHeight;
      view.target = view.target.map((x, k) => x + step * (dy * above[k] - dx * right[k]));
    } else {
      view.yaw -= dx / 150;
      view.pitch = Math.max(-1.55, Math.min(1.55, view.pitch + dy / 150));
    }
    redraw();
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(event.deltaY / 700)); }, { passive: false });
  function zoom(factor) {
    view.distance = Math.max(radius / 500, Math.min(8 * radius, view.distance * factor));
    redraw();
  }

  // Pairs of the frame: a click looks at the deepest point.
  const pairList = stage.querySelector(".pairs");
  function listPairs() {
    const { pairs } = model.frames[frame];
    const text = pairs.length ? "" : "No bodies overlap.";
    pairList.replaceChildren(text, ...pairs.map((pair) => {
      const button = document.createElement("button");
      const isChosen = chosen && chosen.a === pair.a && chosen.b === pair.b;
      button.className = isChosen ? "chosen" : "";
      button.append(span(`${bodies[pair.a].name} × ${bodies[pair.b].name}`), span(`${digits(pair.depth)} ${UNIT}`));
      button.addEventListener("click", () => choose(isChosen ? null : pair));
      return button;
    }));
  }
  function span(text) {
    const made = document.createElement("span");
    made.textContent = text;
    return made;
  }
  function digits(x) {
    return x === 0 ? "0" : x.toPrecision(x >= 1000 ? 4 : 3);
  }
  function choose(pair) {
    chosen = pair;
    if (pair && pair.at) {
      view.target = pair.at.slice();
      view.distance = 0.6 * radius;
    } else {
      fit();
    }
    listPairs();
    drawTime();
    redraw();
  }

  // Color scale, where something is inside something.
  const legend = stage.querySelector(".scale");
  if (model.max_depth > 0) {
    const stops = RAMP.map((color) => `rgb(${color.join()})`).join();
    legend.style.background = `linear-gradient(to right, ${stops})`;
    legend.append(span("0"), span(`depth inside the other body`), span(`${digits(model.max_depth)} ${UNIT}`));
  } else {
    legend.remove();
  }

  // Bodies to show or hide.
  const bodyList = stage.querySelector(".bodies");
  bodies.forEach((body) => {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = true;
    box.addEventListener("change", () => { body.shown = box.checked; redraw(); });
    const swatch = document.createElement("i");
    swatch.style.background = `rgb(${body.color.join()})`;
    label.append(box, swatch, span(body.name));
    bodyList.append(label);
  });

  // Depth over time, of all and of the chosen pair, with the frame as a line.
  const time = stage.querySelector(".time");
  const deepest = model.frames.map(({ pairs }) => Math.max(0, ...pairs.map((pair) => pair.depth)));
  const top = Math.max(...deepest) || 1;
  function drawTime() {
    if (model.frames.length < 2) return;
    const x = (k) => 8 + (984 * k) / (model.frames.length - 1);
    const y = (depth) => 96 - (84 * depth) / top;
    const line = (values, color) =>
      `<polyline fill="none" stroke="${color}" stroke-width="2" points="${values.map((v, k) => `${x(k).toFixed(1)},${y(v).toFixed(1)}`).join(" ")}"/>`;
    const of = (pair, pairs) => pairs.find(({ a, b }) => a === pair.a && b === pair.b);
    const own = chosen ? model.frames.map(({ pairs }) => (of(chosen, pairs) || { depth: 0 }).depth) : null;
    time.querySelector("svg").innerHTML =
      `<line x1="0" x2="1000" y1="96" y2="96" stroke="#ccd"/>` +
      line(deepest, own ? "#ccd" : "#b23a48") + (own ? line(own, "#b23a48") : "") +
      `<line x1="${x(frame)}" x2="${x(frame)}" y1="4" y2="100" stroke="#3b528b" stroke-width="2"/>`;
    time.querySelector(".top").textContent = `${digits(top)} ${UNIT}`;
    const at = model.frames[frame].time;
    const seconds = at === null ? "" : `, ${at} s`;
    time.querySelector("output").textContent = `frame ${frame}${seconds}: deepest ${digits(own ? own[frame] : deepest[frame])} ${UNIT}`;
    time.querySelector("input").value = frame;
  }
  if (model.frames.length > 1) {
    const slider = time.querySelector("input");
    slider.max = model.frames.length - 1;
    slider.addEventListener("input", () => setFrame(slider.valueAsNumber));
    time.querySelector("svg").addEventListener("click", (event) => {
      const box = event.currentTarget.getBoundingClientRect();
      const share = ((event.clientX - box.left) / box.width - 0.008) / 0.984;
      setFrame(Math.round(share * (model.frames.length - 1)));
    });
  } else {
    time.remove();
  }

  // A link may name a frame and a pair: report.html#frame=12&pair=0.
  function follow() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    setFrame(Number(wanted.get("frame")) || 0);
    const pair = model.frames[frame].pairs[wanted.get("pair") ?? -1];
    if (pair) choose(pair);
  }
  stage.classList.add("ready");
  fit();
  window.addEventListener("resize", redraw);
  window.addEventListener("hashchange", follow);
  follow();
})();
