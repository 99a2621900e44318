// Looks closer at lines over time, as report::timeline writes them. A page has the JSON of an axis of time in a script
// "#time-NAME", figures with data-time="NAME" that hold charts (svg.live), and a legend (.legend) for each figure.
//   Plots.read(json)                  the lines: times, and the smallest and largest value of each span
//   Plots.at(lines, t)                the number of the span at a time; -1 where the log has a gap
//   Plots.path(lines, key, [a, b], place)   the path of a line between two times
//   Plots.all(document)               by name: { lines, show(t), zoom([a, b]), onShow }
const Plots = (() => {
  // The number that a span without a value has; it is no number, and so not equal to itself.
  const NONE = 0 / 0;
  const isNone = x => x !== x;
  const code = (text, i, count) => {
    let sum = 0;
    for (let k = i * count; k < (i + 1) * count; k++) {
      const c = text.charCodeAt(k) - 62;
      sum = 64 * sum + c - (c > 30);
    }
    return sum;
  };
  const numbers = (text, count, of) => Float64Array.from({ length: text.length / count }, (_, i) => of(code(text, i, count)));
  const read = ({ from, to, times, pieces, curves }) => {
    const value = ({ low, step }) => c => c > 4094 ? NONE : low + step * c;
    const lines = { from, to, pieces, t: numbers(times, 4, c => from + (to - from) * c / 16777215), curves: {} };
    Object.entries(curves).forEach(([key, curve]) => {
      const low = numbers(curve.lows, 2, value(curve));
      lines.curves[key] = { low, high: curve.highs ? numbers(curve.highs, 2, value(curve)) : low, step: curve.step };
    });
    return lines;
  };

  // The number of the last entry that is not above x.
  const last = (list, x, of = y => y) => {
    let [a, b] = [-1, list.length];
    while (b - a > 1) {
      const middle = (a + b) >> 1;
      if (of(list[middle]) <= x) a = middle; else b = middle;
    }
    return a;
  };
  const at = (lines, t) => {
    const i = last(lines.t, t);
    const piece = last(lines.pieces, i, p => p[0]);
    return i < 0 || t > lines.pieces[piece][1] + 1e-6 ? -1 : i;
  };

  // Spans [t, low, high] of a line around two times, in pieces without a gap.
  const parts = (lines, key, [a, b]) => {
    const { low, high } = lines.curves[key];
    const found = [];
    lines.pieces.forEach(([first, end], k) => {
      const stop = k + 1 < lines.pieces.length ? lines.pieces[k + 1][0] : lines.t.length;
      let part = [];
      // A span that holds several samples reaches up to the next.
      const close = t => {
        if (part.length && high !== low) part.push([t, ...part[part.length - 1].slice(1)]);
        if (part.length) found.push(part);
        part = [];
      };
      for (let i = Math.max(first, last(lines.t, a)); i < stop && (i === first || lines.t[i - 1] <= b); i++) {
        if (isNone(low[i])) close(lines.t[i]); else part.push([lines.t[i], low[i], high[i]]);
      }
      close(end);
    });
    return found;
  };
  // place: from time and value to the chart.
  const path = (lines, key, window, place) => {
    const { low, high } = lines.curves[key];
    return parts(lines, key, window).map(part => {
      const points = part.map(([t, l]) => place(t, l));
      const back = low === high ? [] : part.map(([t, , h]) => place(t, h)).reverse();
      return `M${[...points, ...back].map(p => p.map(Math.round).join(" ")).join("L")}${back.length ? "z" : points.length > 1 ? "" : "h0"}`;
    }).join("");
  };

  // As many digits as the steps of the data have.
  const digits = (x, step) => x.toFixed(Math.max(0, Math.min(8, Math.ceil(-Math.log10(step || 1)))));
  const label = (curve, i) => {
    if (i < 0 || isNone(curve.low[i])) return "–";
    const [a, b] = [curve.low, curve.high].map(of => digits(of[i], curve.step));
    return a === b ? a : `${a} … ${b}`;
  };
  const ticks = (a, b) => {
    const power = 10 ** Math.floor(Math.log10((b - a) / 5));
    const step = [1, 2, 5, 10].map(f => f * power).find(s => s >= (b - a) / 5);
    return Array.from({ length: Math.floor(b / step) - Math.ceil(a / step) + 1 }, (_, i) => {
      const t = (Math.ceil(a / step) + i) * step;
      return [t, digits(t, step)];
    });
  };

  // A chart: its frame, its paths, and how they were at first.
  class Chart {
    constructor(svg, lines) {
      Object.assign(this, { svg, lines, ticks: one(svg, ".ticks"), paths: every(svg, "[data-curve]") });
      [this.x0, this.y0, this.x1, this.y1, this.v0, this.v1] = JSON.parse(svg.dataset.frame);
      // Of a line that is drawn as an outline at first: whether it is none where one looks closer.
      this.paths.forEach(p => p.classList.toggle("single", lines.curves[p.dataset.curve].low === lines.curves[p.dataset.curve].high));
      this.first = [this.ticks.innerHTML, ...this.paths.map(p => p.getAttribute("d"))];
      [this.cursor, this.chosen] = [".cursor", ".chosen"].map(name => one(svg, name));
    }
    time(x, [a, b]) { return a + (b - a) * (x - this.x0) / (this.x1 - this.x0); }
    place(t, [a, b]) { return this.x0 + (this.x1 - this.x0) * (t - a) / (b - a); }
    draw(window, isWhole) {
      const { x0, x1, y0, y1, v0, v1 } = this;
      const place = (t, v) => [this.place(t, window), y0 + (y1 - y0) * (v - v0) / (v1 - v0)];
      this.paths.forEach((p, k) => p.setAttribute("d", isWhole ? this.first[k + 1] : path(this.lines, p.dataset.curve, window, place)));
      this.svg.classList.toggle("zoomed", !isWhole);
      this.ticks.innerHTML = isWhole ? this.first[0] : ticks(...window).map(([t, text]) => {
        const x = Math.round(this.place(t, window));
        return `<path class="grid" d="M${x} ${y0}v40"/><text x="${x}" y="${y0 + 180}" class="middle">${text}</text>`;
      }).join("");
    }
    show(t, window) {
      this.cursor.setAttribute("d", t === null || t < window[0] || t > window[1] ? "" : `M${Math.round(this.place(t, window))} ${this.y1}V${this.y0}`);
    }
    choose(a, b) {
      this.chosen.setAttribute("d", a === null ? "" : `M${a} ${this.y0}V${this.y1}H${b}V${this.y0}z`);
    }
    // Where a pointer is, held inside of the frame.
    under(event) {
      const box = this.svg.getBoundingClientRect();
      const x = (event.clientX - box.left) * this.svg.viewBox.baseVal.width / box.width;
      return Math.max(this.x0, Math.min(this.x1, x));
    }
  }

  // The figures of one axis of time: they show the same span and the same instant.
  class Time {
    constructor(lines, figures) {
      Object.assign(this, { lines, window: [lines.from, lines.to], t: null, onShow: () => {} });
      this.charts = figures.flatMap(figure => every(figure, "svg.live").map(svg => new Chart(svg, lines)));
      this.legends = figures.flatMap(figure => every(figure, ".legend button"));
      this.clocks = figures.flatMap(figure => every(figure, ".clock"));
      this.legends.forEach(button => listen(button, "click", () => this.hide(button)));
      this.charts.forEach(chart => this.follow(chart));
    }
    show(t, isOwn = true) {
      this.t = t;
      const i = t === null ? -1 : at(this.lines, t);
      this.charts.forEach(chart => chart.show(t, this.window));
      this.clocks.forEach(clock => { clock.textContent = t === null ? "" : `${digits(t, 1e-3)} s`; });
      this.legends.forEach(button => {
        const curve = this.lines.curves[button.dataset.key];
        button.lastElementChild.textContent = t === null || !curve ? "" : label(curve, i);
      });
      if (isOwn && t !== null) this.onShow(t);
    }
    zoom([a, b]) {
      const { from, to } = this.lines;
      const length = Math.min(to - from, Math.max(b - a, (to - from) / 2000));
      const start = Math.max(from, Math.min(to - length, a));
      this.window = [start, start + length];
      this.charts.forEach(chart => chart.draw(this.window, length >= to - from));
      this.show(this.t, false);
    }
    around(t, factor) {
      const [a, b] = this.window;
      this.zoom([t - (t - a) * factor, t + (b - t) * factor]);
    }
    hide(button) {
      const isShown = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", isShown);
      every(button.closest("figure"), `[data-curve="${button.dataset.key}"]`).forEach(p => p.classList.toggle("hidden", !isShown));
    }
    key(name) {
      const [a, b] = this.window;
      const t = this.t === null ? (a + b) / 2 : this.t;
      const does = {
        ArrowLeft: () => this.show(t - (b - a) / 100), ArrowRight: () => this.show(t + (b - a) / 100),
        "+": () => this.around(t, 0.7), "-": () => this.around(t, 1.4),
        0: () => this.zoom([-Infinity, Infinity]),
      };
      if (does[name]) does[name]();
      return !!does[name];
    }
    follow(chart) {
      const { svg } = chart;
      let down = null;
      const here = event => chart.time(chart.under(event), this.window);
      const on = (name, does, options) => listen(svg, name, does, options);
      on("pointerdown", event => { if (!event.button) { down = chart.under(event); svg.setPointerCapture(event.pointerId); } });
      on("pointermove", event => {
        this.show(here(event));
        if (down !== null) chart.choose(down, chart.under(event));
      });
      on("pointerup", event => {
        const [a, b] = [down, chart.under(event)].sort((p, q) => p - q);
        if (down !== null && b - a > 60) this.zoom([chart.time(a, this.window), chart.time(b, this.window)]);
        down = null;
        chart.choose(null);
      });
      on("pointercancel", () => { down = null; chart.choose(null); });
      on("pointerleave", () => { if (down === null) this.show(null); });
      on("dblclick", () => this.key("0"));
      on("wheel", event => {
        if (!event.ctrlKey) return;
        event.preventDefault();
        this.around(here(event), event.deltaY < 0 ? 0.8 : 1.25);
      }, { passive: false });
      on("keydown", event => { if (!event.ctrlKey && !event.metaKey && !event.altKey && this.key(event.key)) event.preventDefault(); });
    }
  }
  const all = document => Object.fromEntries(every(document, "script[id^=time-]").map(script => {
    const name = script.id.slice(5);
    return [name, new Time(read(JSON.parse(script.textContent)), every(document, `[data-time="${name}"]`))];
  }));
  return { code, read, at, path, label, all };
})();
