// Draws a robot, as report::drawing writes it, in a figure that holds the JSON. Any page can have one:
//   const view = new Drawing.View(figure)          view.move(values of the variables)
// Drawing.kinematics is the kinematics alone. loops.js closes loops; controls.js adds sliders and the choice of a link.
const Drawing = (() => {
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const plus = (a, b, f = 1) => [0, 1, 2].map(i => a[i] + f * b[i]);
  const scaled = (a, f) => a.map(x => x * f);
  const unit = a => scaled(a, 1 / (Math.hypot(...a) || 1));
  const far = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

  // A pose is 3 x 4, row by row: orientation and position.
  const BASE = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
  const axis = (t, k) => [t[k], t[4 + k], t[8 + k]];
  const at = (t, p) => [0, 1, 2].map(r => t[4 * r] * p[0] + t[4 * r + 1] * p[1] + t[4 * r + 2] * p[2] + t[4 * r + 3]);
  const compose = (a, b) => {
    const p = at(a, axis(b, 3));
    return [0, 1, 2].flatMap(r => [...[0, 1, 2].map(c => a[4 * r] * b[c] + a[4 * r + 1] * b[4 + c] + a[4 * r + 2] * b[8 + c]), p[r]]);
  };
  // iTj = A_j Rz(x_j) or A_j Tz(x_j).
  const placed = (frame, x) => {
    const value = frame.terms.reduce((sum, [k, factor]) => sum + factor * x[k], frame.offset);
    const [s, c] = frame.kind === "revolute" ? [Math.sin(value), Math.cos(value)] : [0, 1];
    return compose(frame.place, [c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, frame.kind === "prismatic" ? value : 0]);
  };
  const on = (poses, frame) => frame.on === null ? BASE : poses[frame.on];
  const poses = (robot, x) => {
    const all = [];
    robot.links.forEach(link => all.push(compose(on(all, link), placed(link, x))));
    return all;
  };

  // The convex hull of points of a plane.
  const hull = points => {
    const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const half = list => list.reduce((found, p) => {
      const turn = () => {
        const [a, b] = found.slice(-2);
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
      };
      while (found.length > 1 && turn() <= 0) found.pop();
      return [...found, p];
    }, []).slice(0, -1);
    return [...half(sorted), ...half(sorted.reverse())];
  };
  const escaped = text => text.replace(/[&<>"]/g, c => `&#${c.charCodeAt()};`);
  const digits = x => (Math.round(x * 10) / 10).toString();

  // Sides of what stands for a joint: a turn is a cylinder, a slide a box.
  const SOLIDS = {
    revolute: { sides: 20, half: 0.055, radius: 0.032, start: 0 },
    prismatic: { sides: 4, half: 0.065, radius: 0.032, start: Math.PI / 4 },
  };
  const solid = (kind, pose, size) => {
    const { sides, half, radius, start } = SOLIDS[kind];
    const ring = z => Array.from({ length: sides }, (_, i) => {
      const angle = start + 2 * Math.PI * i / sides;
      return at(pose, [radius * size * Math.cos(angle), radius * size * Math.sin(angle), z * size]);
    });
    return [ring(-half), ring(half)];
  };

  // What is drawn of a robot that stands so: lines, solids, frames and names in the base frame.
  const parts = (robot, all, size, x) => {
    const lines = [], solids = [], names = [];
    const way = (frame, pose, owner) => {
      const before = on(all, frame);
      const points = [axis(before, 3), ...frame.corners.map(p => at(before, p))];
      points.slice(1).forEach((p, i) => { if (far(p, points[i]) > 1e-6 * size) lines.push({ of: frame.on, kind: "bone", ends: [points[i], p] }); });
      const corner = points[points.length - 1];
      const slides = frame.kind === "prismatic";
      if (far(corner, axis(pose, 3)) > 1e-6 * size) lines.push({ of: slides ? owner : frame.on, kind: slides ? "bone slide" : "bone", ends: [corner, axis(pose, 3)] });
      if (SOLIDS[frame.kind]) solids.push({ of: owner, rings: solid(frame.kind, pose, size) });
    };
    robot.links.forEach((link, j) => {
      way(link, all[j], j);
      link.fixed.forEach(([, p]) => lines.push({ of: j, kind: "bone thin", ends: [axis(all[j], 3), at(all[j], p)] }));
      names.push({ of: j, text: link.name, p: axis(all[j], 3) });
    });
    robot.loops.forEach(pair => pair.forEach(frame => way(frame, compose(on(all, frame), placed(frame, x)), frame.on)));
    return { lines, solids, names };
  };

  const nice = x => {
    const power = 10 ** Math.floor(Math.log10(x));
    return [5, 2, 1].map(m => m * power).find(v => v <= x * 1.0001) || power;
  };

  class View {
    constructor(figure) {
      this.figure = figure;
      this.robot = JSON.parse(one(figure, "script").textContent);
      this.values = this.robot.variables.map(v => v.at);
      if (typeof Loops === "object") Loops.close(this.robot, this.values);
      this.home = this.values.slice();
      const e3 = unit(this.robot.up);
      const e1 = unit(plus([1, 0, 0], e3, -e3[0]).some(v => Math.abs(v) > 1e-3) ? plus([1, 0, 0], e3, -e3[0]) : cross([0, 1, 0], e3));
      this.ground = [e1, cross(e3, e1), e3];
      this.turned = [-1.0, 0.35];
      this.zoom = 1;
      this.build();
      this.fit();
      this.draw();
    }

    build() {
      const { figure } = this;
      [this.svg, this.canvas, this.message, this.scale] = ["svg", "svg g", ".message", ".scale"].map(name => one(figure, name));
      every(figure, "[data-do]").forEach(button => listen(button, "click", () => this.key(button.dataset.do)));
      this.listen();
      if (typeof ResizeObserver === "function") new ResizeObserver(() => this.draw()).observe(this.svg);
    }

    listen() {
      const { svg } = this;
      let down = null;
      listen(svg, "pointerdown", event => {
        if (event.button) return;
        down = { x: event.clientX, y: event.clientY, turned: this.turned };
        svg.setPointerCapture(event.pointerId);
      });
      listen(svg, "pointermove", event => {
        if (!down) return;
        this.turn(down.turned[0] - 0.008 * (event.clientX - down.x), down.turned[1] + 0.008 * (event.clientY - down.y));
      });
      listen(svg, "pointerup", () => { down = null; });
      listen(svg, "pointercancel", () => { down = null; });
      listen(svg, "keydown", event => {
        if (!event.ctrlKey && !event.metaKey && !event.altKey && this.key(event.key)) event.preventDefault();
      });
    }

    // What a key or a button does; false for other keys.
    key(name) {
      const [a, b] = this.turned;
      const does = {
        ArrowLeft: () => this.turn(a + 0.1, b), ArrowRight: () => this.turn(a - 0.1, b),
        ArrowUp: () => this.turn(a, b + 0.1), ArrowDown: () => this.turn(a, b - 0.1),
        "+": () => this.size(1.25), "-": () => this.size(0.8),
        0: () => { this.zoom = 1; this.turn(-1.0, 0.35); },
      };
      if (does[name]) does[name]();
      return !!does[name];
    }

    turn(a, b) {
      this.turned = [a, Math.max(-1.5, Math.min(1.5, b))];
      this.draw();
    }

    size(factor) {
      this.zoom = Math.max(0.5, Math.min(12, this.zoom * factor));
      this.draw();
    }

    // Passive variables are found; false where the loops do not close.
    move(values) {
      const found = typeof Loops === "object" ? Loops.follow(this.robot, this.values, values) : values;
      this.message.textContent = found ? "" : "The loops do not close there.";
      this.values = found || this.values;
      this.fit();
      this.draw();
      return !!found;
    }

    // The middle and the size of all that is drawn; the size does not shrink while joints move.
    fit() {
      const all = poses(this.robot, this.values);
      const { lines } = parts(this.robot, all, 1, this.values);
      const points = [[0, 0, 0], ...all.map(t => axis(t, 3)), ...lines.flatMap(line => line.ends)];
      const [low, high] = [Math.min, Math.max].map(f => [0, 1, 2].map(i => points.reduce((found, p) => f(found, p[i]), points[0][i])));
      const middle = scaled(plus(low, high), 0.5);
      const needed = points.reduce((most, p) => Math.max(most, far(p, middle)), 0) || 0.5;
      if (!this.centre) [this.centre, this.radius] = [middle, needed];
      const reach = points.reduce((most, p) => Math.max(most, far(p, this.centre)), 0);
      this.radius = Math.max(this.radius, reach);
    }

    // From the base frame to the screen: right, down, nearness.
    camera(width, height) {
      const [a, b] = this.turned;
      const [e1, e2, e3] = this.ground;
      const flat = plus(scaled(e1, Math.cos(a)), e2, Math.sin(a));
      const near = plus(scaled(flat, Math.cos(b)), e3, Math.sin(b));
      const right = plus(scaled(e1, -Math.sin(a)), e2, Math.cos(a));
      const up = cross(near, right);
      const centre = this.middle();
      const scale = this.zoom * Math.min(width, height) / (2.45 * this.radius);
      const away = 6 * this.radius;
      return p => {
        const d = plus(p, centre, -1);
        const depth = dot(d, near);
        const f = scale * away / Math.max(away - depth, 0.1 * away);
        return [width / 2 + f * dot(d, right), height / 2 - f * dot(d, up), depth];
      };
    }

    draw() {
      const width = this.svg.clientWidth || 600;
      const height = this.svg.clientHeight || 400;
      this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
      const all = poses(this.robot, this.values);
      const seen = this.camera(width, height);
      const size = 1.6 * this.radius / Math.sqrt(this.zoom);
      const { lines, solids, names } = parts(this.robot, all, size, this.values);
      const xy = p => `${digits(p[0])} ${digits(p[1])}`;
      const path = points => `M${points.map(xy).join("L")}`;
      const is = this.is.bind(this);
      const items = [];
      lines.forEach(({ of, kind, ends }) => {
        const points = ends.map(seen);
        items.push([points[0][2] + points[1][2], `<path ${is(of === null ? `${kind} still` : kind, of)} d="${path(points)}"/>`]);
      });
      solids.forEach(({ of, rings }) => {
        const [below, above] = rings.map(ring => ring.map(seen));
        const depth = ring => ring.reduce((sum, p) => sum + p[2], 0) / ring.length;
        const cap = depth(below) > depth(above) ? below : above;
        items.push([depth(below) + depth(above), `<g ${is("joint", of)}><path d="${path(hull([...below, ...above]))}Z"/><path d="${path(cap)}Z"/></g>`]);
      });
      [[null, BASE], ...all.map((t, j) => [j, t])].filter(([j]) => this.hasFrame(j)).forEach(([j, t]) => items.push(...this.frame(j, t, size, seen, path)));
      items.sort((a, b) => a[0] - b[0]);
      this.canvas.innerHTML = this.floor(seen, path) + items.map(item => item[1]).join("") + this.beside(all, seen) + this.labels(names.filter(name => this.hasName(name.of)), seen, width);
    }

    // What controls.js replaces: what a link is marked with, and what is shown of it.
    middle() { return this.centre; }
    is(kind, link) { return `class="${kind}"`; }
    hasFrame(j) { return true; }
    hasName(j) { return true; }
    lengthOfFrame(j) { return 0.11; }
    letter(j, name, from, to) { return ""; }
    beside(all, seen) { return ""; }

    frame(j, t, size, seen, path) {
      const origin = axis(t, 3);
      return ["x", "y", "z"].flatMap((name, k) => {
        const [a, b] = [origin, plus(origin, axis(t, k), this.lengthOfFrame(j) * size)].map(seen);
        const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        const length = Math.hypot(dx, dy);
        const tip = [];
        if (length > 6) {
          const [ux, uy] = [dx / length, dy / length];
          tip.push([b[0] - 6 * ux - 3 * uy, b[1] - 6 * uy + 3 * ux], b, [b[0] - 6 * ux + 3 * uy, b[1] - 6 * uy - 3 * ux]);
        }
        return [[a[2] + b[2] + 1e-6, `<g ${this.is(`axis ${name}`, j)}><path d="${path([a, b])}"/>${tip.length ? `<path d="${path(tip)}Z"/>` : ""}${this.letter(j, name, a, b)}</g>`]];
      });
    }

    // Squares on the plane through the origin of the base that gravity is normal to.
    floor(seen, path) {
      const step = nice(0.5 * this.radius);
      const [e1, e2] = this.ground;
      const ends = [-2, -1, 0, 1, 2].flatMap(i => [[e1, e2], [e2, e1]].map(([a, b]) => [-2, 2].map(j => plus(scaled(a, i * step), b, j * step))));
      this.scale.textContent = `squares of ${step < 1 ? `${+(step * 1000).toPrecision(2)} mm` : `${+step.toPrecision(2)} m`}`;
      return `<path class="floor" d="${ends.map(line => path(line.map(seen))).join("")}"/>`;
    }

    // Names beside their frames, below each other where frames meet.
    labels(names, seen, right) {
      const taken = [];
      return names.map(name => {
        const [px, py] = seen(name.p);
        const width = 7.5 * name.text.length;
        // At the right edge a name stands left of its frame.
        const x = px + 10 + width < right ? px + 10 : px - 10 - width;
        let y = py - 8;
        const meets = other => Math.abs(other.y - y) < 14 && x < other.x + other.width && other.x < x + width;
        while (taken.some(meets)) y += 14;
        taken.push({ x, y, width });
        return `<text ${this.is("name", name.of)} x="${digits(x)}" y="${digits(y)}">${escaped(name.text)}</text>`;
      }).join("");
    }
  }

  return { kinematics: { at, axis, compose, cross, on, placed, plus, poses, scaled }, escaped, digits, View };
})();
