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
  addEventListener("beforeprint", () => document.querySelectorAll(".chosen").forEach(part => { part.hidden = false; }));
  addEventListener("afterprint", () => all.forEach(show));
})();
