// The map of correlations, and the leverage of rows on the picked parameter, as report::information writes them. Picks by
// the list or by a row of the map; shows the pair under the pointer.
const Maps = (() => {
  // rho of two parameters, and the share of a part of time in one parameter, 0 to 1.
  const rho = (data, i, j) => i === j ? 1 : i < j ? rho(data, j, i) : Plots.code(data.rho, i * (i - 1) / 2 + j, 2) / 2047 - 1;
  const share = (data, k, j, b) => (Plots.code(data.shares, (k * data.joints.length + j) * data.parts + b, 1) / 63) ** 2;
  const of = figure => {
    const data = JSON.parse(one(figure, "script").textContent);
    const [map, label, list, rows] = ["svg", ".label", "select", ".rows"].map(name => one(figure, name));
    const cross = one(map, ".picked");
    const pick = k => {
      list.selectedIndex = k;
      cross.setAttribute("d", `M0 ${k}.5H${data.names.length}M${k}.5 0V${data.names.length}`);
      const sums = data.sums[k];
      every(rows, "tr").forEach((row, j) => {
        row.children[1].textContent = `${(100 * sums[j]).toFixed(sums[j] < 0.1 ? 1 : 0)} %`;
        every(row, "i").forEach((cell, b) => { cell.style.opacity = share(data, k, j, b); });
      });
    };
    const under = event => {
      const box = map.getBoundingClientRect();
      return [event.clientY - box.top, event.clientX - box.left].map(x => Math.max(0, Math.min(data.names.length - 1, Math.floor(x / box.width * data.names.length))));
    };
    const show = event => {
      const [i, j] = under(event);
      label.textContent = `${data.names[i]} and ${data.names[j]}: ${rho(data, i, j).toFixed(3)}`;
    };
    listen(map, "pointermove", show);
    listen(map, "click", event => { show(event); pick(under(event)[0]); });
    listen(list, "change", () => pick(list.selectedIndex));
    pick(list.selectedIndex);
  };
  return { of };
})();
