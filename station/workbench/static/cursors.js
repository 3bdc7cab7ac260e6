// One moment in all pictures, zoom in time, and two cursors with what lies between them.
(() => {
  const bench = (window.bench = window.bench || {}), S = bench.state, TURN = 2 * Math.PI;
  bench.moment = null;
  bench.cursors = [];
  const HINT = "Point at a picture to mark the moment in all. Drag: zoom. Double click: see all. Two clicks: two cursors.";
  const timePlots = () => ["overlay", "left"].map((name) => bench.plots[name]).filter((p) => p && p.alive && p.box);

  function nearest(distance) {
    let best = 0, least = Infinity;
    for (let i = 0; i < S.stage.time.length; i++) {
      const d = distance(i);
      if (d < least) { least = d; best = i; }
    }
    return best;
  }
  const turn = (a, b) => Math.abs(((a - b + 1.5 * TURN) % TURN) - Math.PI);
  function momentAt(name, [x, y]) {
    const t = S.stage, p = bench.plots.map;
    if (name !== "map") return nearest((i) => Math.abs(t.time[i] - x));
    const su = p.x[1] - p.x[0], sv = p.y[1] - p.y[0];
    if (S.map === "plane") return nearest((i) => ((t.displacement[i] - x) / su) ** 2 + ((t.velocity[i] - y) / sv) ** 2);
    if (S.map === "phase") return nearest((i) => turn(t.phase[i], x));
    const across = S.map === "time" ? t.time : t.amplitude;
    return nearest((i) => ((across[i] - x) / su) ** 2 + (turn(t.phase[i], y) / TURN) ** 2);
  }
  function placeOnMap(i) {
    const t = S.stage, p = bench.plots.map;
    if (S.map === "plane") return [p.px(t.displacement[i]), p.py(t.velocity[i])];
    if (S.map === "phase") return [p.px(t.phase[i]), p.py(0)];
    return [p.px((S.map === "time" ? t.time : t.amplitude)[i]), p.py(t.phase[i])];
  }

  function element(host, kind) {
    let el = host.querySelector(`:scope > .mark.${kind}`);
    if (!el) { el = document.createElement("div"); el.className = `mark ${kind}`; host.appendChild(el); }
    return el;
  }
  function bar(plot, kind, t) {
    const el = element(plot.host, kind), x = t === null ? null : plot.px(t);
    const shown = x !== null && x >= plot.box.x - 1 && x <= plot.box.x + plot.box.w + 1;
    el.style.display = shown ? "block" : "none";
    if (shown) Object.assign(el.style, { left: x + "px", top: plot.box.y + "px", height: plot.box.h + "px" });
  }

  bench.mark = (i) => {
    bench.moment = i;
    if (!S.stage) return;
    for (const plot of timePlots()) bar(plot, "now", i === null ? null : S.stage.time[i]);
    const map = bench.plots.map;
    if (map && map.alive && map.box) {
      const el = element(map.host, "dot");
      el.style.display = i === null ? "none" : "block";
      if (i !== null) { const [x, y] = placeOnMap(i); el.style.left = x + "px"; el.style.top = y + "px"; }
    }
    const words = document.getElementById("readout");
    if (words) words.textContent = i === null ? between() || HINT : moment(i);
  };
  function moment(i) {
    const t = S.stage, u = t.units, trace = t.traces[S.channel], left = bench.shown().left[S.channel][i];
    return `t = ${t.time[i].toFixed(3)} s   u = ${t.displacement[i].toPrecision(4)} ${u.u}   v = ${t.velocity[i].toPrecision(3)} ${u.v}   `
      + `residual = ${left === null ? "?" : left.toPrecision(3)} ${trace.fine_unit}`;
  }
  // Cycles between two moments from the phase, which grows by one turn a cycle.
  function between() {
    if (bench.cursors.length < 2 || !S.stage) return "";
    const [a, b] = [...bench.cursors].sort((x, y) => x - y), t = S.stage, span = t.time[b] - t.time[a];
    const rough = span * t.frequency_hz, extra = (((t.phase[b] - t.phase[a]) % TURN) + TURN) % TURN / TURN;
    const cycles = Math.round(rough - extra) + extra, ratio = t.amplitude[a] / t.amplitude[b];
    const decrement = cycles > 0.05 ? (Math.log(ratio) / cycles).toFixed(4) : "?";
    return `Between the cursors: ${span.toFixed(3)} s, ${cycles.toFixed(2)} cycles, amplitude ratio ${ratio.toFixed(3)} `
      + `(${t.amplitude[a].toPrecision(4)} to ${t.amplitude[b].toPrecision(4)} ${t.units.u}), decrement ${decrement} a cycle`;
  }
  bench.between = between;
  bench.drawCursors = () => {
    if (!S.stage) return;
    for (const plot of timePlots())
      ["one", "two"].forEach((kind, k) => bar(plot, kind, bench.cursors[k] === undefined ? null : S.stage.time[bench.cursors[k]]));
  };
  bench.setCursor = (i) => { bench.cursors = bench.cursors.length === 2 ? [i] : [...bench.cursors, i]; bench.drawCursors(); bench.mark(null); };
  // The moments that stay marked when the samples are others: those nearest in time.
  bench.keepMoments = (before) => {
    if (!before) return;
    const same = (i) => nearest((k) => Math.abs(S.stage.time[k] - before.time[i]));
    bench.cursors = bench.cursors.map(same);
    if (bench.moment !== null) bench.moment = same(bench.moment);
  };
  bench.clearCursors = () => { bench.cursors = []; bench.drawCursors(); bench.mark(null); };

  // Zoom.
  bench.zoomTo = (low, high) => {
    const t = S.stage.time, ends = [Math.min(0, t[0]), t[t.length - 1]], least = (ends[1] - ends[0]) / 2000;
    low = Math.max(ends[0], low); high = Math.min(ends[1], high);
    if (high - low < least) return;
    S.zoom = low <= ends[0] && high >= ends[1] ? null : [low, high];
    bench.draw();
  };
  bench.seeAll = () => { S.zoom = null; bench.draw(); };
  const plotAt = (event) => {
    const host = event.target.closest && event.target.closest("[data-plot]"), plot = host && bench.plots[host.dataset.plot];
    if (!plot || !plot.box || !S.stage) return null;
    const box = host.getBoundingClientRect();
    return { name: host.dataset.plot, plot, at: plot.at(event.clientX - box.left, event.clientY - box.top) };
  };
  let drag = null, latest = null;
  document.addEventListener("mousedown", (event) => {
    const hit = plotAt(event);
    if (hit && hit.at && hit.name !== "map" && event.button === 0) { drag = { plot: hit.plot, from: hit.at[0], to: hit.at[0], x: event.clientX }; event.preventDefault(); hit.plot.host.focus({ preventScroll: true }); }
  });
  document.addEventListener("mousemove", (event) => {
    if (!S.stage) return;
    const waiting = latest !== null;
    latest = event;  // the frame that is drawn next knows where the pointer is by then, not where it was when one was asked for
    if (waiting) return;
    requestAnimationFrame(() => {
      const hit = plotAt(latest);
      latest = null;
      if (drag && hit && hit.at && hit.plot === drag.plot) { drag.to = hit.at[0]; shade(); }
      if (hit && hit.at) bench.mark(momentAt(hit.name, hit.at));
      else if (bench.moment !== null) bench.mark(null);
    });
  });
  function shade() {
    for (const plot of timePlots()) {
      const el = element(plot.host, "span"), far = drag && Math.abs(plot.px(drag.to) - plot.px(drag.from)) > 6;
      el.style.display = far ? "block" : "none";
      if (far) Object.assign(el.style, { left: Math.min(plot.px(drag.from), plot.px(drag.to)) + "px", width: Math.abs(plot.px(drag.to) - plot.px(drag.from)) + "px", top: plot.box.y + "px", height: plot.box.h + "px" });
    }
  }
  document.addEventListener("mouseup", (event) => {
    if (!drag) return;
    const done = drag, far = Math.abs(event.clientX - done.x) > 6;
    drag = null; shade();
    if (far) bench.zoomTo(Math.min(done.from, done.to), Math.max(done.from, done.to));
    else bench.setCursor(nearest((i) => Math.abs(S.stage.time[i] - done.from)));
  });
  document.addEventListener("dblclick", (event) => { const hit = plotAt(event); if (hit && hit.name !== "map") { bench.cursors = []; bench.seeAll(); } });
  document.addEventListener("wheel", (event) => {
    const hit = event.ctrlKey && plotAt(event);
    if (!hit || !hit.at || hit.name === "map") return;  // without Ctrl the wheel scrolls the page
    event.preventDefault();
    const [low, high] = bench.span(), k = event.deltaY > 0 ? 1.25 : 0.8, t = hit.at[0];
    bench.zoomTo(t - (t - low) * k, t + (high - t) * k);
  }, { passive: false });

  // The same with the keyboard.
  document.addEventListener("keydown", (event) => {
    const el = document.activeElement;
    if (!el || !el.dataset || !el.dataset.plot || !S.stage) return;
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key], last = S.stage.time.length - 1, now = bench.moment ?? 0;
    const [low, high] = bench.span(), middle = S.stage.time[now];
    if (step) bench.mark(Math.min(last, Math.max(0, now + step * (event.shiftKey ? 16 : 1))));
    else if (event.key === "Enter" || event.key === " ") bench.setCursor(now);
    else if (event.key === "+") bench.zoomTo(middle - (middle - low) * 0.7, middle + (high - middle) * 0.7);
    else if (event.key === "-") bench.zoomTo(middle - (middle - low) * 1.4, middle + (high - middle) * 1.4);
    else if (event.key === "Escape") { bench.clearCursors(); bench.seeAll(); }
    else return;
    event.preventDefault();
  });
})();
