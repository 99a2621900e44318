(() => {
  const table = document.getElementById("table");
  if (table) {
    const rows = every(table, "tr[data-order]");
    const home = new Map(rows.map(row => [row, row.parentElement]));
    const heads = every(table, "th[data-key]");
    const byLink = () => {
      table.classList.remove("sorted");
      heads.forEach(head => head.removeAttribute("aria-sort"));
      rows.forEach(row => home.get(row).append(row));
    };
    const sort = head => {
      const key = head.dataset.key;
      const up = head.getAttribute("aria-sort") === "descending" || (key === "name" && !head.hasAttribute("aria-sort"));
      heads.forEach(other => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const of = row => key === "number" ? Math.abs(+row.dataset[key]) : +row.dataset[key];
      const order = key === "name"
        ? (a, b) => a.dataset.name.localeCompare(b.dataset.name, "en", { numeric: true })
        : (a, b) => of(a) - of(b);
      table.classList.add("sorted");
      const body = table.tBodies[0];
      [...rows].sort((a, b) => (up ? 1 : -1) * order(a, b)).forEach(row => body.append(row));
    };
    heads.forEach(head => {
      listen(one(head, "button"), "click", () => sort(head));
    });
    listen(document.getElementById("by-link"), "click", byLink);
  }
  const opened = [];
  listen(window, "beforeprint", () => every(document, "details:not([open])").forEach(d => { d.open = true; opened.push(d); }));
  listen(window, "afterprint", () => opened.splice(0).forEach(d => { d.open = false; }));
})();
