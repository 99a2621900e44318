(() => {
  const show = choose => document.querySelectorAll("." + choose.dataset.of).forEach(part => {
    part.hidden = part.id !== choose.value;
  });
  const all = document.querySelectorAll(".choose");
  all.forEach(choose => { choose.addEventListener("change", () => show(choose)); show(choose); });
  const base = document.getElementById("choose-base");
  document.querySelectorAll("[data-show]").forEach(link => link.addEventListener("click", event => {
    event.preventDefault();
    base.value = "base-" + link.dataset.show;
    show(base);
    base.scrollIntoView({ behavior: "smooth", block: "start" });
  }));
  // The drawing and the list show the same link.
  const link = document.getElementById("choose-fate");
  const figure = document.getElementById("drawing");
  const view = figure && Drawing.of(figure);
  const picked = () => link.selectedIndex < 0 ? null : link.selectedIndex;
  const pick = (k, to) => {
    link.selectedIndex = k;
    show(link);
    if (view) view.pick(k);
    if (to) to.scrollIntoView({ behavior: "smooth", block: "start" });
  };
  link.addEventListener("change", () => view && view.pick(picked()));
  if (view) {
    view.pick(picked());
    figure.addEventListener("pick", event => event.detail === null ? view.pick(null) : pick(event.detail));
  }
  document.querySelectorAll("[data-pick]").forEach(row => row.addEventListener("click", event => {
    event.preventDefault();
    pick(row.dataset.pick - 1, figure || link);
  }));
  addEventListener("beforeprint", () => {
    document.querySelectorAll(".chosen").forEach(part => { part.hidden = false; });
    document.querySelectorAll(".notes").forEach(notes => { notes.open = true; });
  });
  addEventListener("afterprint", () => all.forEach(show));
})();
