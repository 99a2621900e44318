// Draws a robot, as report::drawing writes it, in a figure that holds the JSON. Any page can have one:
//   const view = Drawing.of(figure)          view.move(values of the variables)          view.pick(link or null)
// The figure gets an event "pick" when a link is chosen in it. Drawing.poses is the kinematics alone.
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

  // Of each loop: from one frame to the other, and the sine of the turn between them.
  const gap = (robot, x) => {
    const all = poses(robot, x);
    return robot.loops.flatMap(pair => {
      const [a, b] = pair.map(frame => compose(on(all, frame), placed(frame, x)));
      const turn = [0, 1, 2].map(k => cross(axis(a, k), axis(b, k))).reduce((sum, v) => plus(sum, v, 0.5), [0, 0, 0]);
      return [...plus(axis(b, 3), axis(a, 3), -1), ...turn];
    });
  };
  const largest = e => e.reduce((most, v) => Math.max(most, Math.abs(v)), 0);
  // y of (J'J + mu 1) y = J'e, by elimination: the matrix is positive definite.
  const leastSquares = (columns, e) => {
    const n = columns.length;
    const inner = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
    const m = columns.map((a, i) => [...columns.map((b, j) => inner(a, b) + (i === j ? 1e-12 : 0)), inner(a, e)]);
    for (let k = 0; k < n; k++) {
      for (let i = k + 1; i < n; i++) {
        const factor = m[i][k] / m[k][k];
        for (let j = k; j <= n; j++) m[i][j] -= factor * m[k][j];
      }
    }
    const y = new Array(n).fill(0);
    for (let k = n - 1; k >= 0; k--) y[k] = (m[k][n] - y.reduce((sum, v, j) => sum + (j > k ? m[k][j] * v : 0), 0)) / m[k][k];
    return y;
  };
  // Moves the passive variables of x until the loops are closed, by Gauss-Newton; false where they do not close.
  const close = (robot, x) => {
    const passive = robot.variables.map((_, k) => k).slice(robot.coordinates);
    if (!passive.length) return true;
    for (let step = 0; step < 40; step++) {
      const e = gap(robot, x);
      if (largest(e) < 1e-10) return true;
      const columns = passive.map(k => {
        const [ahead, behind] = [1e-6, -1e-6].map(h => gap(robot, x.map((v, i) => i === k ? v + h : v)));
        return ahead.map((v, i) => (v - behind[i]) / 2e-6);
      });
      const y = leastSquares(columns, e);
      for (let fraction = 1; fraction > 1e-3; fraction /= 2) {
        const next = x.slice();
        passive.forEach((k, i) => { next[k] -= fraction * y[i]; });
        if (fraction < 2e-3 || largest(gap(robot, next)) < largest(e)) { next.forEach((v, k) => { x[k] = v; }); break; }
      }
    }
    return largest(gap(robot, x)) < 1e-7;
  };
  // From closed values to the coordinates of others, in strides that keep the assembly; null where the way ends.
  const follow = (robot, from, to) => {
    const n = robot.coordinates;
    if (robot.variables.length === n) return to.slice(0, n);
    const most = largest(from.slice(0, n).map((v, k) => to[k] - v));
    const strides = Math.min(200, Math.max(1, Math.ceil(most / 0.05)));
    const x = from.slice();
    for (let s = 1; s <= strides; s++) {
      for (let k = 0; k < n; k++) x[k] = from[k] + (to[k] - from[k]) * s / strides;
      if (!close(robot, x)) return null;
    }
    return x;
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
  const escaped = text => text.replace(/[&<>"]/g, c => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
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
      this.robot = JSON.parse(figure.querySelector("script").textContent);
      this.values = this.robot.variables.map(v => v.at);
      close(this.robot, this.values);
      this.home = this.values.slice();
      this.picked = null;
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
      const { robot, figure } = this;
      const count = robot.links.length;
      const box = document.createElement("div");
      box.innerHTML = `<svg tabindex="0" role="img" aria-label="${escaped(robot.name)}: ${count} ${count === 1 ? "link" : "links"} with their frames. Arrow keys turn it, plus and minus change its size, n and p pick a link."><g></g></svg>
<p class="tools"><button type="button" data-do="-" aria-label="smaller">−</button> <button type="button" data-do="+" aria-label="larger">+</button> <button type="button" data-do="0">as at first</button>
<label><input type="checkbox" data-of="frames" checked> frames</label> <label><input type="checkbox" data-of="names" checked> names</label>
<span><b class="x">x</b> <b class="y">y</b> <b class="z">z</b></span> <span class="scale"></span></p>
<p class="message" role="status"></p>
<details class="sliders"><summary>Joints</summary>${robot.variables.slice(0, robot.coordinates).map((v, k) => `<label><span>${escaped(v.name)}</span><input type="range" min="${v.from}" max="${v.to}" step="any" value="${v.at}" data-variable="${k}"><output></output></label>`).join("")}</details>`;
      figure.append(...box.childNodes);
      const find = selector => figure.querySelector(selector);
      [this.svg, this.canvas, this.message, this.scale] = [find("svg"), find("svg g"), find(".message"), find(".scale")];
      // On a narrow screen the chosen link comes before the joints.
      find(".sliders").open = matchMedia("(min-width: 801px)").matches;
      this.sliders = [...figure.querySelectorAll("[data-variable]")];
      this.sliders.forEach((slider, k) => slider.addEventListener("input", () => {
        this.move(this.values.map((v, i) => i === k ? +slider.value : v));
      }));
      figure.querySelectorAll("[type=checkbox]").forEach(box => box.addEventListener("change", () => this.draw()));
      figure.querySelectorAll("[data-do]").forEach(button => button.addEventListener("click", () => this.key(button.dataset.do)));
      this.listen();
      if (typeof ResizeObserver === "function") new ResizeObserver(() => this.draw()).observe(this.svg);
      this.tell();
    }

    listen() {
      const { svg } = this;
      let down = null;
      svg.addEventListener("pointerdown", event => {
        if (event.button) return;
        down = { x: event.clientX, y: event.clientY, turned: this.turned, link: event.target.closest("[data-link]"), moved: false };
        svg.setPointerCapture(event.pointerId);
      });
      svg.addEventListener("pointermove", event => {
        if (!down) return;
        const [dx, dy] = [event.clientX - down.x, event.clientY - down.y];
        down.moved ||= Math.hypot(dx, dy) > 4;
        if (down.moved) this.turn(down.turned[0] - 0.008 * dx, down.turned[1] + 0.008 * dy);
      });
      svg.addEventListener("pointerup", () => {
        if (down && !down.moved) this.choose(down.link ? +down.link.dataset.link : null);
        down = null;
      });
      svg.addEventListener("pointercancel", () => { down = null; });
      svg.addEventListener("wheel", event => {
        if (!event.ctrlKey) return;
        event.preventDefault();
        this.key(event.deltaY < 0 ? "+" : "-");
      }, { passive: false });
      svg.addEventListener("keydown", event => {
        if (!event.ctrlKey && !event.metaKey && !event.altKey && this.key(event.key)) event.preventDefault();
      });
    }

    // What a key or a button does; false for other keys.
    key(name) {
      const [a, b] = this.turned;
      const count = this.robot.links.length;
      const beside = step => this.choose(this.picked === null ? (step > 0 ? 0 : count - 1) : (this.picked + step + count) % count);
      const does = {
        ArrowLeft: () => this.turn(a + 0.1, b), ArrowRight: () => this.turn(a - 0.1, b),
        ArrowUp: () => this.turn(a, b + 0.1), ArrowDown: () => this.turn(a, b - 0.1),
        "+": () => this.size(1.25), "=": () => this.size(1.25), "-": () => this.size(0.8),
        n: () => beside(1), p: () => beside(-1),
        0: () => { this.turned = [-1.0, 0.35]; this.zoom = 1; this.move(this.home); },
      };
      if (!does[name]) return false;
      does[name]();
      return true;
    }

    turn(a, b) {
      this.turned = [a, Math.max(-1.5, Math.min(1.5, b))];
      this.draw();
    }

    size(factor) {
      this.zoom = Math.max(0.5, Math.min(12, this.zoom * factor));
      this.draw();
    }

    // By the user: the page is told.
    choose(link) {
      this.pick(link);
      this.figure.dispatchEvent(new CustomEvent("pick", { detail: link }));
    }

    pick(link) {
      this.picked = link;
      this.draw();
    }

    // Passive variables are found; false where the loops do not close.
    move(values) {
      const found = follow(this.robot, this.values, values);
      this.message.textContent = found ? "" : "The loops do not close there.";
      this.values = found || this.values;
      this.tell();
      this.fit();
      this.draw();
      return !!found;
    }

    tell() {
      this.sliders.forEach((slider, k) => {
        const value = this.values[k];
        slider.value = value;
        const told = this.robot.variables[k].turns ? `${value.toFixed(3)} rad, ${digits(value * 180 / Math.PI)}°` : `${value.toFixed(3)} m`;
        slider.nextElementSibling.textContent = told;
        slider.setAttribute("aria-valuetext", told);
      });
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
      const target = this.picked === null ? this.centre : axis(poses(this.robot, this.values)[this.picked], 3);
      const centre = plus(scaled(this.centre, Math.min(1, 1 / this.zoom)), target, Math.max(0, 1 - 1 / this.zoom));
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
      const is = (kind, link) => `class="${kind}${link !== null && link === this.picked ? " picked" : ""}"${link === null ? "" : ` data-link="${link}"`}`;
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
      if (this.shows("frames")) {
        const shown = [[null, BASE], ...all.map((t, j) => [j, t])];
        shown.forEach(([j, t]) => items.push(...this.frame(j, t, size, seen, path, is)));
      } else if (this.picked !== null) {
        items.push(...this.frame(this.picked, all[this.picked], size, seen, path, is));
      }
      items.sort((a, b) => a[0] - b[0]);
      this.canvas.innerHTML = this.floor(seen, path) + items.map(item => item[1]).join("") + this.centreOfMass(all, seen) + this.labels(names, seen, is, width);
    }

    shows(what) {
      return this.figure.querySelector(`[data-of=${what}]`).checked;
    }

    frame(j, t, size, seen, path, is) {
      const origin = axis(t, 3);
      const long = (j === this.picked && j !== null ? 0.17 : 0.11) * size;
      return ["x", "y", "z"].flatMap((name, k) => {
        const [a, b] = [origin, plus(origin, axis(t, k), long)].map(seen);
        const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        const length = Math.hypot(dx, dy);
        const tip = [];
        if (length > 6) {
          const [ux, uy] = [dx / length, dy / length];
          tip.push([b[0] - 6 * ux - 3 * uy, b[1] - 6 * uy + 3 * ux], b, [b[0] - 6 * ux + 3 * uy, b[1] - 6 * uy - 3 * ux]);
        }
        const letter = j === this.picked && j !== null && length > 6 ? `<text x="${digits(b[0] + 9 * dx / length)}" y="${digits(b[1] + 9 * dy / length + 4)}" class="letter ${name}">${name}</text>` : "";
        return [[a[2] + b[2] + 1e-6, `<g ${is(`axis ${name}`, j)}><path d="${path([a, b])}"/>${tip.length ? `<path d="${path(tip)}Z"/>` : ""}${letter}</g>`]];
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

    centreOfMass(all, seen) {
      const link = this.picked === null ? null : this.robot.links[this.picked];
      if (!link || !link.mass_centre) return "";
      const [x, y] = seen(at(all[this.picked], link.mass_centre)).map(digits);
      return `<g class="mass"><circle cx="${x}" cy="${y}" r="6"/><path d="M${x} ${y}m-6 0a6 6 0 0 1 6 -6v12a6 6 0 0 0 6 -6z"/></g>`;
    }

    // Names beside their frames, below each other where frames meet.
    labels(names, seen, is, right) {
      const shown = names.filter(name => this.shows("names") || name.of === this.picked);
      const taken = [];
      return shown.map(name => {
        const [px, py] = seen(name.p);
        const width = 7.5 * name.text.length;
        // At the right edge a name stands left of its frame.
        const x = px + 10 + width < right ? px + 10 : px - 10 - width;
        let y = py - 8;
        const meets = other => Math.abs(other.y - y) < 14 && x < other.x + other.width && other.x < x + width;
        while (taken.some(meets)) y += 14;
        taken.push({ x, y, width });
        return `<text ${is("name", name.of)} x="${digits(x)}" y="${digits(y)}">${escaped(name.text)}</text>`;
      }).join("");
    }
  }

  return { poses, follow, of: figure => new View(figure) };
})();
