// A drawing in which one picks a link, moves each coordinate and says what is shown.
//   const view = Controls.of(figure)          view.pick(link or null)
// The figure gets an event "pick" when a link is chosen in it.
const Controls = (() => {
  const { digits, escaped } = Drawing;
  const { at, axis, plus, poses, scaled } = Drawing.kinematics;

  class View extends Drawing.View {
    build() {
      super.build();
      const { robot, figure, svg } = this;
      svg.setAttribute("aria-label", `${svg.getAttribute("aria-label").slice(0, -1)}, n and p pick a link.`);
      one(figure, ".tools").insertAdjacentHTML("beforeend", `<label><input type="checkbox" data-of="frames" checked> frames</label> <label><input type="checkbox" data-of="names" checked> names</label>`);
      figure.insertAdjacentHTML("beforeend", `<details class="sliders"><summary>Joints</summary>${robot.variables.slice(0, robot.coordinates).map((v, k) => `<label><span>${escaped(v.name)}</span><input type="range" min="${v.from}" max="${v.to}" step="any" value="${v.at}" data-variable="${k}"><output></output></label>`).join("")}</details>`);
      // On a narrow screen the chosen link comes before the joints.
      one(figure, ".sliders").open = matchMedia("(min-width: 801px)").matches;
      this.picked = null;
      this.sliders = every(figure, "[data-variable]");
      this.sliders.forEach((slider, k) => listen(slider, "input", () => {
        this.move(this.values.map((v, i) => i === k ? +slider.value : v));
      }));
      every(figure, "[type=checkbox]").forEach(box => listen(box, "change", () => this.draw()));
      this.tell();
    }

    listen() {
      super.listen();
      const { svg } = this;
      let down = null;
      listen(svg, "pointerdown", event => {
        down = event.button ? null : { x: event.clientX, y: event.clientY, link: event.target.closest("[data-link]") };
      });
      listen(svg, "pointerup", event => {
        if (down && Math.hypot(event.clientX - down.x, event.clientY - down.y) <= 4) this.choose(down.link ? +down.link.dataset.link : null);
        down = null;
      });
      listen(svg, "wheel", event => {
        if (!event.ctrlKey) return;
        event.preventDefault();
        this.key(event.deltaY < 0 ? "+" : "-");
      }, { passive: false });
    }

    key(name) {
      const count = this.robot.links.length;
      const beside = step => this.choose(this.picked === null ? (step > 0 ? 0 : count - 1) : (this.picked + step + count) % count);
      if (name === "0") this.move(this.home);
      if (name === "n" || name === "p") beside(name === "n" ? 1 : -1);
      return name === "n" || name === "p" || super.key(name);
    }

    // A change by the user is passed on to the page.
    choose(link) {
      this.pick(link);
      this.figure.dispatchEvent(new CustomEvent("pick", { detail: link }));
    }

    pick(link) {
      this.picked = link;
      this.draw();
    }

    move(values) {
      const found = super.move(values);
      this.tell();
      return found;
    }

    tell() {
      this.sliders.forEach((slider, k) => {
        const value = this.values[k];
        slider.value = value;
        const text = this.robot.variables[k].turns ? `${value.toFixed(3)} rad, ${digits(value * 180 / Math.PI)}°` : `${value.toFixed(3)} m`;
        slider.nextElementSibling.textContent = text;
        slider.setAttribute("aria-valuetext", text);
      });
    }

    shows(what) { return one(this.figure, `[data-of=${what}]`).checked; }
    isPicked(j) { return j !== null && j === this.picked; }
    is(kind, link) { return `class="${kind}${this.isPicked(link) ? " picked" : ""}"${link === null ? "" : ` data-link="${link}"`}`; }
    hasFrame(j) { return this.shows("frames") || this.isPicked(j); }
    hasName(j) { return this.shows("names") || this.isPicked(j); }
    lengthOfFrame(j) { return this.isPicked(j) ? 0.17 : 0.11; }

    // The closer one looks, the more the picked link is in the middle.
    middle() {
      if (this.picked === null) return this.centre;
      const target = axis(poses(this.robot, this.values)[this.picked], 3);
      return plus(scaled(this.centre, Math.min(1, 1 / this.zoom)), target, Math.max(0, 1 - 1 / this.zoom));
    }

    letter(j, name, a, b) {
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      const [x, y] = [0, 1].map(i => b[i] + 9 * (b[i] - a[i]) / length);
      return this.isPicked(j) && length > 6 ? `<text x="${digits(x)}" y="${digits(y + 4)}" class="letter ${name}">${name}</text>` : "";
    }

    beside(all, seen) {
      const link = this.picked === null ? null : this.robot.links[this.picked];
      if (!link || !link.mass_centre) return "";
      const [x, y] = seen(at(all[this.picked], link.mass_centre)).map(digits);
      return `<g class="mass"><circle cx="${x}" cy="${y}" r="6"/><path d="M${x} ${y}m-6 0a6 6 0 0 1 6 -6v12a6 6 0 0 0 6 -6z"/></g>`;
    }
  }
  return { of: figure => new View(figure) };
})();
