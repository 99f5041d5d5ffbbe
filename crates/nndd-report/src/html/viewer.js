// The view of a solid that turns. Without script or WebGL the picture below it stays.
"use strict";
(() => {
  const block = document.getElementById("viewer");
  const canvas = block.querySelector("canvas");
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) return;
  const data = JSON.parse(document.getElementById("skin").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const control = (name) => block.querySelector(`[name=${name}]`);
  const compiled = (kind, text) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + text);
    gl.compileShader(shader);
    return shader;
  };
  const program = gl.createProgram();
  gl.attachShader(program, compiled(gl.VERTEX_SHADER, `
    in vec3 place; in vec3 moved; in vec3 apart; in float value;
    uniform vec3 low, extent, middle; uniform float largest, factor, opened, clipAt, bias;
    uniform mat3 turn; uniform vec2 zoom, pan; uniform vec3 clip;
    out vec3 seen; out float height, away;
    void main() {
      vec3 rest = low + extent * place;
      vec3 p = rest + factor * largest * moved + opened * apart;
      seen = turn * (p - middle);
      height = value;
      away = dot(rest, clip) - clipAt;
      gl_Position = vec4(seen.xy * zoom + pan, -seen.z * min(zoom.x, zoom.y) * 0.25 - bias, 1.0);
    }`));
  gl.attachShader(program, compiled(gl.FRAGMENT_SHADER, `
    in vec3 seen; in float height, away;
    uniform vec3 colours[${data.colours.length}]; uniform bool lines; uniform vec3 ink;
    out vec4 colour;
    void main() {
      if (away > 0.0) discard;
      if (lines) { colour = vec4(ink, 1.0); return; }
      vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
      n *= n.z < 0.0 ? -1.0 : 1.0;
      float light = 0.7 + 0.3 * clamp(dot(n, vec3(0.3, 0.5, 0.81)), 0.0, 1.0);
      int band = int(clamp(height * 65535.0 / 65534.0, 0.0, 0.9999) * ${data.colours.length}.0);
      vec3 shade = height > 0.999995 ? vec3(0.72, 0.76, 0.8) : colours[band];
      colour = vec4((gl_FrontFacing ? shade : 0.6 * shade) * light, 1.0);
    }`));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return;
  gl.useProgram(program);
  const at = (name) => gl.getUniformLocation(program, name);
  const attribute = (name, array, size, type, whole) => {
    const place = gl.getAttribLocation(program, name);
    if (place < 0) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, type, whole, 0, 0);
  };
  const bodies = new Uint16Array(bytes(data.bodies));
  const apart = new Float32Array(3 * bodies.length);
  bodies.forEach((body, k) => apart.set(data.apart[body], 3 * k));
  // The middle of all bodies that are moved apart, and by how much that makes the scene longer.
  const ends = [0, 1, 2].map((k) => [Math.min, Math.max].map((end) => end(...data.apart.map((way) => way[k]))));
  const centre = ends.map(([low, high]) => 0.5 * (low + high));
  const spread = Math.hypot(...ends.map(([low, high]) => high - low));
  attribute("place", new Uint16Array(bytes(data.places)), 3, gl.UNSIGNED_SHORT, true);
  attribute("apart", apart, 3, gl.FLOAT, false);
  const indices = (text) => {
    const array = new Uint32Array(bytes(text));
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, array, gl.STATIC_DRAW);
    return { buffer, count: array.length };
  };
  const [faces, edges] = [indices(data.faces), indices(data.edges)];
  gl.uniform3fv(at("low"), data.low);
  gl.uniform3fv(at("extent"), data.extent);
  gl.uniform3fv(at("colours"), data.colours.flatMap((c) => [1, 3, 5].map((k) => parseInt(c.slice(k, k + 2), 16) / 255)));
  gl.enable(gl.DEPTH_TEST);

  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((x) => x / Math.hypot(...a));
  const start = { view: data.view, scale: 1, pan: [0, 0] };
  let state;
  // Turns two axes of the view by an angle.
  const turned = (view, i, j, angle) => {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const axes = view.slice();
    axes[i] = view[i].map((x, k) => c * x + s * view[j][k]);
    axes[j] = view[j].map((x, k) => c * x - s * view[i][k]);
    const towards = unit(axes[2]);
    const right = unit(cross(axes[1], towards));
    return [right, cross(towards, right), towards];
  };
  const turn = (x, y) => {
    state.view = turned(turned(state.view, 0, 2, x), 1, 2, -y);
    ask();
  };
  const grow = (by) => {
    state.scale = Math.min(50, Math.max(0.2, state.scale * by));
    ask();
  };
  let asked = false;
  const ask = () => {
    if (!asked) requestAnimationFrame(draw);
    asked = true;
  };
  const draw = () => {
    asked = false;
    const ratio = window.devicePixelRatio || 1;
    const [w, h] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    gl.viewport(0, 0, w, h);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const opened = +control("opened").value;
    const size = Math.hypot(...data.extent);
    const zoom = (1.8 * state.scale * Math.min(w, h)) / (size + opened * spread);
    gl.uniformMatrix3fv(at("turn"), true, state.view.flat());
    gl.uniform2f(at("zoom"), zoom / w, zoom / h);
    gl.uniform2fv(at("pan"), state.pan);
    gl.uniform1f(at("factor"), +control("factor").value * data.factor);
    gl.uniform1f(at("opened"), opened);
    gl.uniform3fv(at("middle"), data.low.map((x, k) => x + 0.5 * data.extent[k] + opened * centre[k]));
    const axis = "xyz".indexOf(control("clip").value || "none");
    const normal = [0, 1, 2].map((k) => (k === axis ? 1 : 0));
    gl.uniform3fv(at("clip"), normal);
    gl.uniform1f(at("clipAt"), axis < 0 ? 1 : data.low[axis] + +control("clip_at").value * data.extent[axis]);
    control("clip_at").disabled = axis < 0;
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    gl.uniform3fv(at("ink"), dark ? [0.05, 0.05, 0.05] : [0.1, 0.1, 0.1]);
    for (const [shapes, kind, lines] of [[faces, gl.TRIANGLES, 0], [edges, gl.LINES, 1]]) {
      gl.uniform1i(at("lines"), lines);
      gl.uniform1f(at("bias"), 0.002 * lines);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, shapes.buffer);
      gl.drawElements(kind, shapes.count, gl.UNSIGNED_INT, 0);
    }
    const real = data.factor * +control("factor").value;
    block.querySelector("output").textContent = `displacements × ${+real.toPrecision(3)}`;
  };
  const choose = () => {
    const step = data.steps[control("step") ? +control("step").value : data.steps.length - 1];
    const field = step.fields[+control("field").value] || step.fields[0];
    attribute("moved", new Int16Array(bytes(step.moved)), 3, gl.SHORT, true);
    gl.uniform1f(at("largest"), step.largest);
    attribute("value", new Uint16Array(bytes(field.values)), 1, gl.UNSIGNED_SHORT, true);
    block.querySelector(".bar b").textContent = field.label;
    block.querySelector(".ticks").innerHTML = "";
    for (const [place, text] of field.ticks) {
      const tick = document.createElement("span");
      tick.style.left = `${100 * place}%`;
      tick.textContent = text;
      block.querySelector(".ticks").append(tick);
    }
    canvas.setAttribute("aria-label", `${field.said} Arrow keys turn the view, plus and minus change its size.`);
    ask();
  };
  const reset = () => {
    state = { ...start };
    ask();
  };

  const pointers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    const other = [...pointers].find(([id]) => id !== event.pointerId);
    if (other) {
      const far = (p) => Math.hypot(p[0] - other[1][0], p[1] - other[1][1]) + 1;
      state.pan = [state.pan[0] + dx / canvas.clientWidth, state.pan[1] - dy / canvas.clientHeight];
      grow(far(now) / far(before));
    } else if (event.shiftKey || event.buttons === 2) {
      state.pan = [state.pan[0] + (2 * dx) / canvas.clientWidth, state.pan[1] - (2 * dy) / canvas.clientHeight];
      ask();
    } else {
      turn(-0.01 * dx, -0.01 * dy);
    }
    pointers.set(event.pointerId, now);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    grow(Math.exp(-0.001 * event.deltaY));
  }, { passive: false });
  const keys = {
    ArrowLeft: () => turn(0.1, 0), ArrowRight: () => turn(-0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1),
    "+": () => grow(1.1), "=": () => grow(1.1), "-": () => grow(1 / 1.1), Home: reset,
  };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  canvas.addEventListener("dblclick", reset);
  data.steps[data.steps.length - 1].fields.forEach((field, k) => control("field").append(new Option(field.name, k)));
  if (data.steps.length > 1) {
    data.steps.forEach((step, k) => control("step").append(new Option(step.name, k, k === data.steps.length - 1, k === data.steps.length - 1)));
  } else {
    control("step").parentElement.remove();
  }
  block.querySelector(".colours").style.background =
    `linear-gradient(to right,${data.colours.map((c, k) => `${c} ${(100 * k) / data.colours.length}% ${(100 * (k + 1)) / data.colours.length}%`)})`;
  control("field").addEventListener("change", choose);
  if (control("step")) control("step").addEventListener("change", choose);
  for (const name of ["factor", "opened", "clip", "clip_at"]) control(name).addEventListener("input", ask);
  block.querySelector("button").addEventListener("click", reset);
  window.addEventListener("resize", ask);
  block.classList.add("turns");
  state = { ...start };
  choose();
})();
