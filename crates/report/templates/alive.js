// What of a page is alive: the plots, the robot that moves along them, the map of correlations.
(() => {
  const times = Plots.all(document);
  every(document, "figure.map").forEach(figure => Maps.of(figure));
  every(document, "figure.drawing").forEach(figure => {
    const view = new Drawing.View(figure);
    const time = times[figure.dataset.along];
    if (!time) return;
    const [play, slider, clock] = ["[data-play]", "[type=range]", ".player output"].map(name => one(figure, name));
    const { lines } = time;
    [slider.min, slider.max, slider.value] = [lines.from, lines.to, lines.from];
    time.onShow = t => {
      slider.value = t;
      clock.textContent = `${t.toFixed(2)} s`;
      const i = Plots.at(lines, t);
      if (i >= 0) view.move(view.values.map((x, k) => lines.curves[`q${k}`] ? lines.curves[`q${k}`].low[i] : x));
    };
    // The time of the frame before; null while it stands still.
    let before = null;
    const set = now => {
      before = now;
      play.textContent = now === null ? "play" : "stop";
    };
    const step = now => {
      if (before === null) return;
      const t = +slider.value + (now - before) / 1000;
      set(t < lines.to ? now : null);
      time.show(Math.min(t, lines.to));
      requestAnimationFrame(step);
    };
    const stop = () => set(null);
    listen(play, "click", () => {
      if (before !== null) return stop();
      if (+slider.value >= lines.to) slider.value = lines.from;
      set(performance.now());
      requestAnimationFrame(step);
    });
    listen(slider, "input", () => { stop(); time.show(+slider.value); });
    // Its size is that of the robot where the log begins.
    view.centre = null;
    time.onShow(lines.from);
  });
})();
