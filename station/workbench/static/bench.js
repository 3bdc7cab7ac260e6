// Linked pointers: the moment under the pointer in one chart is marked in all of them.
(() => {
  const bench = { moment: null, motion: null };
  window.bench = bench;

  bench.dark = () => {
    const kept = localStorage.getItem("bench-theme");
    return kept ? kept === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  };
  bench.keepTheme = (dark) => localStorage.setItem("bench-theme", dark ? "dark" : "light");
  bench.setMotion = (motion) => { bench.motion = motion; bench.mark(null); };

  const charts = () => [...document.querySelectorAll("[data-kind]")].filter((el) => el.offsetParent);
  const chartOf = (el) => { const c = window.getElement(Number(el.id.replace(/^c/, ""))); return c && c.chart; };

  function nearest(distance) {
    let best = 0, least = Infinity;
    for (let i = 0; i < bench.motion.t.length; i++) {
      const d = distance(i);
      if (d < least) { least = d; best = i; }
    }
    return best;
  }

  function momentAt(kind, x, y) {
    const m = bench.motion, su = m.su, sv = m.sv, near = 0.08;
    if (kind === "time") return nearest((i) => Math.abs(m.t[i] - x));
    if (kind === "plane") return nearest((i) => ((m.u[i] - x) / su) ** 2 + ((m.v[i] - y) / sv) ** 2);
    if (kind === "at-middle") return nearest((i) => Math.abs(m.v[i] - x) / sv + (Math.abs(m.u[i]) / su > near ? 9 : 0));
    return nearest((i) => Math.abs(m.u[i] - x) / su + (Math.abs(m.v[i]) / sv > 4 * near ? 9 : 0));
  }

  function place(el, kind, chart, i) {
    let mark = el.querySelector(":scope > .mark");
    if (!mark) {
      mark = document.createElement("div");
      mark.className = "mark " + (kind === "plane" ? "dot" : "bar");
      el.appendChild(mark);
    }
    if (i === null) { mark.style.display = "none"; return; }
    const m = bench.motion;
    const x = { time: m.t[i], plane: m.u[i], "at-middle": m.v[i], "at-reversal": m.u[i] }[kind];
    const at = chart.convertToPixel({ gridIndex: 0 }, [x, kind === "plane" ? m.v[i] : 0]);
    const grid = chart.getModel().getComponent("grid").coordinateSystem.getRect();
    if (!at || at[0] < grid.x - 1 || at[0] > grid.x + grid.width + 1) { mark.style.display = "none"; return; }
    mark.style.display = "block";
    mark.style.left = at[0] + "px";
    mark.style.top = (kind === "plane" ? at[1] : grid.y) + "px";
    if (kind !== "plane") mark.style.height = grid.height + "px";
  }

  bench.mark = (i) => {
    bench.moment = i;
    for (const el of charts()) {
      const chart = chartOf(el);
      if (chart && bench.motion) place(el, el.dataset.kind, chart, i);
    }
    const words = document.getElementById("readout"), m = bench.motion;
    if (!words || !m) return;
    words.textContent = i === null ? m.hint
      : `t = ${m.t[i].toFixed(3)} s   u = ${m.u[i].toPrecision(4)} ${m.uu}   v = ${m.v[i].toPrecision(3)} ${m.vu}   missing force = ${m.f[i] === null ? "?" : m.f[i].toPrecision(3)} ${m.fu}`;
  };

  let waiting = false;
  document.addEventListener("mousemove", (event) => {
    const el = event.target.closest && event.target.closest("[data-kind]");
    if (waiting || !bench.motion || (!el && bench.moment === null)) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      if (!el) return bench.mark(null);
      const chart = chartOf(el), box = el.getBoundingClientRect();
      if (!chart) return;
      const pixel = [event.clientX - box.left, event.clientY - box.top];
      if (!chart.containPixel({ gridIndex: 0 }, pixel)) return bench.mark(null);
      const [x, y] = chart.convertFromPixel({ gridIndex: 0 }, pixel);
      bench.mark(momentAt(el.dataset.kind, x, y));
    });
  });

  document.addEventListener("keydown", (event) => {
    const el = document.activeElement;
    if (!el || !el.dataset || !el.dataset.kind || !bench.motion) return;
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const last = bench.motion.t.length - 1;
    bench.mark(Math.min(last, Math.max(0, (bench.moment ?? 0) + step * (event.shiftKey ? 16 : 1))));
  });

  bench.link = () => {
    const [over, left] = ["overlay", "residual"].map((name) => document.querySelector(`[data-name=${name}]`));
    const [a, b] = [over, left].map((el) => el && chartOf(el));
    if (!a || !b) { setTimeout(bench.link, 60); return; }
    for (const [one, other] of [[a, b], [b, a]]) {
      if (one.linkedTo === other) continue;
      one.linkedTo = other;
      one.on("datazoom", () => {
        const { start, end } = one.getOption().dataZoom[0], now = other.getOption().dataZoom[0];
        if (now.start !== start || now.end !== end) other.dispatchAction({ type: "dataZoom", start, end });
        bench.mark(bench.moment);
      });
    }
  };
})();
