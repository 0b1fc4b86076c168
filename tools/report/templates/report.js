"use strict";
// What moves in the report: the two views in space, and the answer for the task's tolerance.

const figures = JSON.parse(document.getElementById("figures").textContent);
const control = (name) => document.querySelector(`[data-control="${name}"]`);

function errorsScene() {
  const orbit = new Orbit(-2.3, 0.42);
  const filter = control("filter");
  const role = (sample) => figures.placements[sample.placement].role;
  const chosen = (sample) =>
    filter.value === "all" || filter.value === role(sample) || filter.value === `${sample.placement}`;
  const half = +filter.dataset.half;
  const limit = figures.limits.mean_absolute_error.value;

  for (const canvas of document.querySelectorAll('canvas[data-scene="errors"]')) {
    const model = canvas.dataset.model;
    new View(canvas, orbit, (view) => {
      view.centre = [0, 0, 0];
      view.scale = Math.min(view.width, view.height) / (3.05 * half);
      box(view, half);
      const samples = figures.samples.filter(chosen).map((row) => [pointOf(row, model), row]);
      samples.sort((a, b) => view.project(a[0])[2] - view.project(b[0])[2]);
      for (const [point, row] of samples) view.dot(point, 2.8, model, role(row) === "train");
      if (limit) ring(view, limit);
      canvas.dataset.points = samples.length;
    });
  }
  filter.addEventListener("input", () => orbit.redraw());
}

// What calibrated.urdf says, as it is loaded.
function pointOf(row, model) {
  return model === "nominal" ? row.nominal : (row.geometric ?? row.calibrated);
}

function box(view, half) {
  const ends = [-half, half];
  for (const a of ends) {
    for (const b of ends) {
      view.line([[-half, a, b], [half, a, b]], "rule");
      view.line([[a, -half, b], [a, half, b]], "rule");
      view.line([[a, b, -half], [a, b, half]], "rule");
    }
  }
  const words = `${+(1e3 * half).toPrecision(3)} mm`;
  [["x", [half, 0, 0]], ["y", [0, half, 0]], ["z", [0, 0, half]]].forEach(([name, end]) => {
    view.line([end.map((v) => -v), end], "axis");
    view.text(end, `${name} ${words}`);
  });
}

function ring(view, radius) {
  const context = view.context;
  context.beginPath();
  context.arc(view.width / 2, view.height / 2, radius * view.scale * view.orbit.zoom, 0, 2 * Math.PI);
  context.setLineDash([4, 3]);
  context.strokeStyle = view.colour("ink");
  context.lineWidth = 1.2;
  context.stroke();
  context.setLineDash([]);
}

function armScene() {
  const arm = figures.arm;
  const orbit = new Orbit(-2.2, 0.35);
  const [slider, factor, overlay] = ["configuration", "factor", "overlay"].map(control);
  const apart = (k) =>
    arm.nominal[k].map((p, i) =>
      p.map((v, c) => arm.calibrated[k][i][c] + +factor.value * (v - arm.calibrated[k][i][c])),
    );
  const canvas = document.querySelector('canvas[data-scene="arm"]');
  const size = Math.hypot(...arm.low.map((low, k) => arm.high[k] - low));
  const every = arm.calibrated.map((_, k) => k);
  new View(canvas, orbit, (view) => {
    view.centre = arm.low.map((low, k) => (low + arm.high[k]) / 2);
    view.scale = Math.min(view.width / 1.05, view.height / 0.8) / size;
    ground(view, arm.reach);
    if (overlay.checked) {
      view.context.globalAlpha = 0.07;
      for (const k of every) view.line(arm.calibrated[k], "calibrated", 2);
      for (const k of every) view.line(apart(k), "nominal", 2);
      view.context.globalAlpha = 1;
    }
    sockets(view);
    const k = +slider.value;
    bodies(view, k);
    links(view, apart(k), "nominal", [7, 5]);
    links(view, arm.calibrated[k], "calibrated", []);
    names(view);
    canvas.dataset.configuration = k;
  });
  for (const input of [slider, factor, overlay]) {
    input.addEventListener("input", () => orbit.redraw());
  }
}

function links(view, points, colour, dash) {
  view.line(points, colour, 3.5, dash);
  for (const point of points.slice(0, -1)) view.dot(point, 3.5, colour, true);
  view.dot(points[points.length - 1], 6, colour);
}

// The links' shapes, where the model has them.
function bodies(view, configuration) {
  const { meshes, frames } = figures.arm;
  if (!meshes.length) return;
  const row = frames[configuration];
  const faces = meshes.flatMap((mesh) => {
    const T = row[mesh.frame];
    const placed = mesh.vertices.map((v) =>
      [0, 4, 8].map((k) => T[k] * v[0] + T[k + 1] * v[1] + T[k + 2] * v[2] + T[k + 3]),
    );
    return mesh.faces.map((face) => face.map((i) => placed[i]));
  });
  view.context.globalAlpha = 0.85;
  view.triangles(faces, "arm");
  view.context.globalAlpha = 1;
}

function ground(view, reach) {
  const count = Math.ceil(reach / 0.2);
  for (let k = -count; k <= count; k += 1) {
    view.line([[0.2 * k, -0.2 * count, 0], [0.2 * k, 0.2 * count, 0]], "rule");
    view.line([[-0.2 * count, 0.2 * k, 0], [0.2 * count, 0.2 * k, 0]], "rule");
  }
  [["x", [0.2, 0, 0]], ["y", [0, 0.2, 0]], ["z", [0, 0, 0.2]]].forEach(([name, end]) => {
    view.line([[0, 0, 0], end], "muted", 1.5);
    view.text(end, name);
  });
}

function sockets(view) {
  for (const placement of figures.placements) {
    const centres = placement.sockets.map((socket) => socket.centre);
    view.line(centres, "ink", 5);
    for (const centre of centres) view.dot(centre, 4, "ink", true);
  }
}

function names(view) {
  const taken = [];
  for (const placement of figures.placements) {
    const centres = placement.sockets.map((socket) => socket.centre);
    const name = placement.name.split("/").pop();
    let [x, y] = view.project(centres[0]);
    // A label that would stand on another one goes below it.
    while (taken.some(([a, b]) => Math.abs(a - x) < 7 * name.length && Math.abs(b - y) < 13)) y += 3;
    taken.push([x, y]);
    view.text(centres[0], name, "ink", 7, 14 + y - view.project(centres[0])[1]);
  }
}

function toleranceControl() {
  const input = control("tolerance");
  const errors = figures.placements.map((_, i) =>
    figures.samples
      .filter((row) => row.placement === i)
      .map((row) => Math.hypot(...pointOf(row, "calibrated"))),
  );
  const steps = JSON.parse(document.getElementById("by-tolerance").textContent);
  const show = () => {
    const allowed = input.valueAsNumber / 1e3;
    if (!(allowed > 0)) return;
    const step = steps.filter((one) => one.allowed <= allowed).pop();
    step.answers.forEach((word, i) => {
      const mark = word.split(" ")[0];
      for (const badge of document.querySelectorAll(`[data-answer="${i}"]`)) {
        badge.textContent = word;
        badge.className = `badge ${mark}`;
      }
      const share = errors[i].filter((error) => error <= allowed).length / errors[i].length;
      document.querySelector(`[data-within="${i}"]`).textContent = `${Math.floor(100 * share)} %`;
      document.querySelector(`circle[data-placement="${i}"]`).setAttribute("class", `answer ${mark}`);
    });
    const number = `${+(1e3 * allowed).toPrecision(6)}`;
    document.querySelector("[data-shown='tolerance']").textContent = `${+(1e3 * allowed).toFixed(3)} mm`;
    document.getElementById("use-text").textContent = step.use.join(number);
    document.querySelector("#table-map figcaption").textContent = step.map.join(number);
  };
  input.addEventListener("input", show);
}

// Paper is light; it has what the reader opened.
addEventListener("beforeprint", () => document.documentElement.classList.add("paper"));
addEventListener("afterprint", () => document.documentElement.classList.remove("paper"));

if (document.querySelector("canvas")) {
  errorsScene();
  armScene();
  toleranceControl();
}
