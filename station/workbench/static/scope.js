// The live scope: the newest seconds of the channel that triggers, its zero, its noise, and the swing that counts as a release.
(() => {
  const bench = (window.bench = window.bench || {});
  let plot = null;
  bench.scope = (now) => {
    const host = document.querySelector("[data-plot=scope]");
    if (!host || !host.clientWidth || !now.points.length) return;
    if (!plot || plot.host !== host) plot = new bench.Plot(host, { bottom: 34, right: 92 });
    bench.scoped = now;
    plot.redraw = () => draw(now);
    draw(now);
  };
  function draw(now) {
    const zero = now.zero ?? 0, values = now.points.map((p) => p[1] - zero), floor = now.level ? 1.4 * now.level : 1e-9;
    const reach = Math.max(floor, 1.15 * bench.reach(values));
    plot.begin([-8, 0], [zero - reach, zero + reach], ["seconds until now [s]", `${now.channel} [${now.unit}]`]);
    plot.axes();
    if (now.noise) plot.band(zero - 2 * now.noise, zero + 2 * now.noise, bench.colour("noise"));
    const right = plot.box.x + plot.box.w, c = plot.c;
    const mark = (y, words, colour, dash) => {
      plot.clip(() => { c.strokeStyle = colour; c.lineWidth = 1; c.setLineDash(dash); c.beginPath(); c.moveTo(plot.box.x, plot.py(y)); c.lineTo(right, plot.py(y)); c.stroke(); });
      c.setLineDash([]);
      if (!words) return;
      c.fillStyle = colour; c.textAlign = "left"; c.textBaseline = "middle"; c.fillText(words, right + 6, plot.py(y));
    };
    if (now.level) { mark(zero + now.level, "release", bench.colour("bad"), [6, 4]); mark(zero - now.level, "", bench.colour("bad"), [6, 4]); }
    if (now.zero !== null) mark(zero, now.level && plot.py(zero) - plot.py(zero + now.level) < 13 ? "" : "zero", bench.colour("good"), []);
    plot.line(now.points.map((p) => p[0]), now.points.map((p) => p[1]), bench.colour("left"), 1.6);
  }
})();
