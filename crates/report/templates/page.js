(() => {
  const table = document.getElementById("table");
  if (table) {
    const rows = [...table.querySelectorAll("tr[data-order]")];
    const home = new Map(rows.map(row => [row, row.parentElement]));
    const heads = [...table.querySelectorAll("th[data-key]")];
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
      const button = head.querySelector("[role=button]");
      button.addEventListener("click", () => sort(head));
      button.addEventListener("keydown", event => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); sort(head); } });
    });
    document.getElementById("by-link").addEventListener("click", byLink);
  }
  const opened = [];
  addEventListener("beforeprint", () => document.querySelectorAll("details:not([open])").forEach(d => { d.open = true; opened.push(d); }));
  addEventListener("afterprint", () => opened.splice(0).forEach(d => { d.open = false; }));
})();
