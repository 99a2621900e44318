(() => {
  const show = choose => every(document, "." + choose.dataset.of).forEach(part => {
    part.hidden = part.id !== choose.value;
  });
  const all = every(document, ".choose");
  all.forEach(choose => { listen(choose, "change", () => show(choose)); show(choose); });
  const base = document.getElementById("choose-base");
  every(document, "[data-show]").forEach(link => listen(link, "click", event => {
    event.preventDefault();
    base.value = "base-" + link.dataset.show;
    show(base);
    base.scrollIntoView({ behavior: "smooth", block: "start" });
  }));
  // The drawing and the list show the same link.
  const link = document.getElementById("choose-fate");
  const figure = document.getElementById("drawing");
  const view = figure && Controls.of(figure);
  const picked = () => link.selectedIndex < 0 ? null : link.selectedIndex;
  const pick = (k, to) => {
    link.selectedIndex = k;
    show(link);
    if (view) view.pick(k);
    if (to) to.scrollIntoView({ behavior: "smooth", block: "start" });
  };
  listen(link, "change", () => view && view.pick(picked()));
  if (view) {
    view.pick(picked());
    listen(figure, "pick", event => event.detail === null ? view.pick(null) : pick(event.detail));
  }
  every(document, "[data-pick]").forEach(row => listen(row, "click", event => {
    event.preventDefault();
    pick(row.dataset.pick - 1, figure || link);
  }));
  listen(window, "beforeprint", () => {
    every(document, ".chosen").forEach(part => { part.hidden = false; });
    every(document, ".notes").forEach(notes => { notes.open = true; });
  });
  listen(window, "afterprint", () => all.forEach(show));
})();
