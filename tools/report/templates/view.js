"use strict";
// A canvas that shows points, lines and triangles in space, turned by mouse, finger or arrow keys.

class Orbit {
  // What several canvases share: they turn together.
  constructor(yaw, pitch) {
    this.start = { yaw, pitch, zoom: 1 };
    this.views = [];
    this.reset();
  }

  reset() {
    Object.assign(this, this.start);
    this.redraw();
  }

  turn(dx, dy) {
    this.yaw -= dx * 0.008;
    this.pitch = Math.min(1.55, Math.max(-1.55, this.pitch + dy * 0.008));
    this.redraw();
  }

  enlarge(factor) {
    this.zoom = Math.min(60, Math.max(0.3, this.zoom * factor));
    this.redraw();
  }

  redraw() {
    for (const view of this.views) view.request();
  }
}

class View {
  constructor(canvas, orbit, draw) {
    this.canvas = canvas;
    this.orbit = orbit;
    this.draw = draw;
    this.context = canvas.getContext("2d");
    this.pointers = new Map();
    this.pending = false;
    orbit.views.push(this);
    this.listen();
    new ResizeObserver(() => this.request()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.request());
    for (const event of ["beforeprint", "afterprint"]) addEventListener(event, () => this.paint());
  }

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event);
    });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener("dblclick", () => this.orbit.reset());
    canvas.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey) return; // the page scrolls
        event.preventDefault();
        this.orbit.enlarge(Math.exp(-event.deltaY * 0.002));
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const others = [...this.pointers.values()].filter((p) => p.pointerId !== event.pointerId);
    if (others.length) {
      const far = (p) => Math.hypot(p.clientX - others[0].clientX, p.clientY - others[0].clientY);
      this.orbit.enlarge(far(event) / Math.max(far(before), 1));
    } else {
      this.orbit.turn(event.clientX - before.clientX, event.clientY - before.clientY);
    }
    this.pointers.set(event.pointerId, event);
  }

  key(event) {
    const steps = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] };
    if (event.key in steps) this.orbit.turn(...steps[event.key]);
    else if (event.key === "+") this.orbit.enlarge(1.2);
    else if (event.key === "-") this.orbit.enlarge(1 / 1.2);
    else return;
    event.preventDefault();
  }

  request() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => this.paint());
  }

  paint() {
    this.pending = false;
    const { canvas, context, orbit } = this;
    const ratio = Math.max(2, devicePixelRatio || 1);
    this.width = canvas.clientWidth;
    this.height = canvas.clientHeight;
    if (!this.width) return;
    canvas.width = Math.round(this.width * ratio);
    canvas.height = Math.round(this.height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.sine = [Math.sin(orbit.yaw), Math.sin(orbit.pitch)];
    this.style = getComputedStyle(canvas);
    this.cosine = [Math.cos(orbit.yaw), Math.cos(orbit.pitch)];
    this.draw(this);
    canvas.dataset.yaw = orbit.yaw.toFixed(4);
    canvas.dataset.pitch = orbit.pitch.toFixed(4);
  }

  // A colour of the style sheet, by its name: it follows light and dark mode.
  colour(name) {
    return this.style.getPropertyValue(`--${name}`).trim();
  }

  // Where a point [x, y, z] lies: right, down, and towards the eye, in pixels.
  project(point) {
    const [sy, sp] = this.sine;
    const [cy, cp] = this.cosine;
    const [x, y, z] = [0, 1, 2].map((k) => point[k] - this.centre[k]);
    const across = -sy * x + cy * y;
    const ahead = cy * x + sy * y;
    const scale = this.scale * this.orbit.zoom;
    return [
      this.width / 2 + scale * across,
      this.height / 2 - scale * (cp * z - sp * ahead),
      scale * (sp * z + cp * ahead),
    ];
  }

  line(points, colour, width = 1, dash = []) {
    const context = this.context;
    context.beginPath();
    points.forEach((point, k) => {
      const [x, y] = this.project(point);
      if (k) context.lineTo(x, y);
      else context.moveTo(x, y);
    });
    context.setLineDash(dash);
    context.strokeStyle = this.colour(colour);
    context.lineWidth = width;
    context.lineJoin = context.lineCap = "round";
    context.stroke();
    context.setLineDash([]);
  }

  dot(point, radius, colour, hollow = false) {
    const context = this.context;
    const [x, y] = this.project(point);
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    if (hollow) {
      context.fillStyle = this.colour("page");
      context.strokeStyle = this.colour(colour);
      context.lineWidth = 1.2;
      context.fill();
      context.stroke();
    } else {
      context.fillStyle = this.colour(colour);
      context.fill();
    }
  }

  text(point, words, colour = "muted", dx = 4, dy = -4) {
    const [x, y] = this.project(point);
    this.context.font = "12px system-ui, sans-serif";
    this.context.strokeStyle = this.colour("page"); // so that it can be read upon a line
    this.context.lineWidth = 3;
    this.context.strokeText(words, x + dx, y + dy);
    this.context.fillStyle = this.colour(colour);
    this.context.fillText(words, x + dx, y + dy);
  }

  // Flat-shaded triangles, the farthest first; each is [a, b, c] with corners in space.
  triangles(faces, colour) {
    const context = this.context;
    const rgb = this.colour(colour).split(" ").map(Number);
    const shown = faces.map((face) => face.map((corner) => this.project(corner)));
    const depth = (face) => face[0][2] + face[1][2] + face[2][2];
    shown.sort((a, b) => depth(a) - depth(b));
    for (const [a, b, c] of shown) {
      const u = [0, 1, 2].map((k) => b[k] - a[k]);
      const v = [0, 1, 2].map((k) => c[k] - a[k]);
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const light = 0.55 + 0.45 * Math.abs((n[2] - 0.4 * n[1]) / (1.08 * Math.hypot(...n) || 1));
      context.beginPath();
      context.moveTo(a[0], a[1]);
      context.lineTo(b[0], b[1]);
      context.lineTo(c[0], c[1]);
      context.closePath();
      context.fillStyle = `rgb(${rgb.map((value) => Math.round(value * light)).join(" ")})`;
      context.fill();
    }
  }
}
