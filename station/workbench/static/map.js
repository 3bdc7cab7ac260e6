// The map of the missing force: colour where the model lacks a force, grey where what is left is within the noise.
(() => {
  const bench = (window.bench = window.bench || {}), S = bench.state;
  const SURE = [1.6, 2.6], TURN = 2 * Math.PI;
  const QUARTERS = [[0, "0"], [TURN / 4, "¼"], [TURN / 2, "½"], [(3 * TURN) / 4, "¾"], [TURN, "1"]];

  function mixer(neutral = "map-middle") {
    const low = bench.rgb("map-low"), middle = bench.rgb(neutral), high = bench.rgb("map-high");
    return (force, std) => {
      const sure = Math.min(1, Math.max(0, (Math.abs(force) / std - SURE[0]) / (SURE[1] - SURE[0])));
      const share = sure * Math.min(1, Math.abs(force) / S.reach), end = force > 0 ? high : low;
      return `rgb(${middle.map((m, k) => Math.round(m + share * (end[k] - m))).join(",")})`;
    };
  }

  // The outline of a cell in the coordinates of the chosen map.
  function outline(kind, axes, code) {
    const columns = axes.columns.length - 1, row = Math.floor(code / columns), column = code % columns;
    const [a, b] = [axes.rows[row], axes.rows[row + 1]], [p, q] = [axes.columns[column], axes.columns[column + 1]];
    if (kind === "amplitude") return [[a, p], [b, p], [b, q], [a, q]];
    if (kind === "time") return [[a, p], [b, p], [b, q], [a, q]];
    const k = S.stage.velocity_per_amplitude, points = [], steps = 3;
    const at = (size, angle) => [size * Math.cos(angle), -size * k * Math.sin(angle)];
    for (let i = 0; i <= steps; i++) points.push(at(b, p + ((q - p) * i) / steps));
    for (let i = steps; i >= 0; i--) points.push(at(a, p + ((q - p) * i) / steps));
    return points;
  }

  function frameOfAxes(p, stage) {
    const u = stage.units, largest = stage.cycle.rows[stage.cycle.rows.length - 1];
    if (S.map === "plane") {
      const side = 1.04 * largest, up = side * stage.velocity_per_amplitude;
      p.begin([-side, side], [-up, up], [`displacement [${u.u}]`, `velocity [${u.v}]`]);
      p.axes();
    } else if (S.map === "phase") {
      const reach = 1.15 * bench.reach(S.base.cycle, 1);
      p.begin([0, TURN], [-reach, reach], ["phase [cycles]; 0 at the largest displacement", `missing force [${u.f}]`]);
      p.axes({ xTicks: QUARTERS });
    } else {
      const rows = (S.map === "time" ? stage.over_time : stage.cycle).rows;
      p.begin([rows[0], rows[rows.length - 1]], [0, TURN], [S.map === "time" ? "time since the release [s]" : `amplitude [${u.u}]`, "phase [cycles]; 0 at the largest displacement"]);
      p.axes({ yTicks: QUARTERS });
    }
  }

  bench.drawMap = (p, frame, stage) => {
    S.base = S.frames[S.steps[0]] || frame;
    p.begin([0, 1], [0, 1], ["", ""]);
    frameOfAxes(p, stage);
    const time = S.map === "time", axes = time ? stage.over_time : stage.cycle;
    const force = time ? frame.time : bench.faded ? bench.faded.cycle : frame.cycle;
    const std = time ? frame.time_std : bench.faded ? bench.faded.cycle_std : frame.cycle_std, colour = mixer();
    if (S.map === "phase") return phasePoints(p, axes, force, std, mixer("ghost"), stage);
    p.clip((c) => {
      axes.cells.forEach((code, i) => {
        if (force[i] === null) return;
        c.fillStyle = c.strokeStyle = colour(force[i], std[i]);
        c.lineWidth = 0.6; c.beginPath();
        outline(S.map, axes, code).forEach(([x, y], n) => (n ? c.lineTo(p.px(x), p.py(y)) : c.moveTo(p.px(x), p.py(y))));
        c.closePath(); c.fill(); c.stroke();
      });
    });
    key(p, stage);
  };

  function phasePoints(p, axes, force, std, colour, stage) {
    const columns = axes.columns.length - 1, rows = axes.rows.length - 1;
    p.clip((c) => {
      axes.cells.forEach((code, i) => {
        if (force[i] === null) return;
        const row = Math.floor(code / columns), column = code % columns;
        const x = p.px((axes.columns[column] + axes.columns[column + 1]) / 2 + ((row / rows - 0.5) * 0.6 * TURN) / columns);
        c.strokeStyle = c.fillStyle = colour(force[i], std[i]);
        c.lineWidth = 1; c.globalAlpha = 0.5; c.beginPath(); c.moveTo(x, p.py(force[i] - 2 * std[i])); c.lineTo(x, p.py(force[i] + 2 * std[i])); c.stroke();
        c.globalAlpha = 1; c.beginPath(); c.arc(x, p.py(force[i]), 1.4 + (2.6 * row) / rows, 0, TURN); c.fill();
      });
    });
    key(p, stage);
  }

  function key(p, stage) {
    const { c, box: b } = p, x = b.x + b.w + 10, high = bench.rgb("map-high"), low = bench.rgb("map-low"), middle = bench.rgb("map-middle");
    const h = Math.min(150, b.h - 96), top = b.y + 46, written = (v) => Number(v.toPrecision(2)).toString().replace("-", "\u2212");
    const shade = c.createLinearGradient(0, top, 0, top + h);
    for (const [at, [r, g, bl]] of [[0, high], [0.5, middle], [1, low]]) shade.addColorStop(at, `rgb(${r},${g},${bl})`);
    c.fillStyle = shade; c.fillRect(x, top, 12, h);
    c.strokeStyle = bench.colour("faint"); c.lineWidth = 1; c.strokeRect(x + 0.5, top + 0.5, 11, h - 1);
    c.fillStyle = bench.colour("ink"); c.textAlign = "left"; c.textBaseline = "middle";
    c.fillText("missing", x, b.y + 8);
    c.fillText("force,", x, b.y + 21);
    c.fillText(stage.units.f, x, b.y + 34);
    c.fillText(`+${written(S.reach)}`, x + 16, top + 4);
    c.fillText("0", x + 16, top + h / 2);
    c.fillText(written(-S.reach), x + 16, top + h - 4);
    c.fillStyle = `rgb(${middle.join(",")})`; c.fillRect(x, top + h + 12, 12, 12); c.strokeRect(x + 0.5, top + h + 12.5, 11, 11);
    c.fillStyle = bench.colour("faint"); c.fillText("within", x + 16, top + h + 14); c.fillText("noise", x + 16, top + h + 26);
  }

  // From one frame to the next in a few steps, so that the eye sees the map bleach.
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let running = 0, slow = false;
  bench.fade = () => {
    const before = bench.drawn, after = bench.shown();
    if (!after) return;
    bench.drawn = after;
    running += 1;
    const asked = performance.now();
    requestAnimationFrame((now) => { slow = now - asked > 40; });  // a busy computer shows the end at once
    if (still.matches || slow || !before || before === after || before.cycle.length !== after.cycle.length) { bench.faded = null; bench.draw(); return; }
    const mine = running, begun = performance.now(), lasts = 50;
    const mix = (k, key) => after[key].map((x, i) => (x === null || before[key][i] === null ? x : before[key][i] + k * (x - before[key][i])));
    bench.faded = { cycle: mix(0.35, "cycle"), cycle_std: after.cycle_std };
    bench.draw();
    const step = (now) => {
      if (mine !== running) return;
      const k = Math.min(1, (now - begun) / lasts);
      bench.faded = k < 1 ? { cycle: mix(0.35 + 0.65 * k, "cycle"), cycle_std: after.cycle_std } : null;
      const map = bench.plots.map;
      if (map && map.alive) bench.drawMap(map, after, S.stage);
      bench.mark(bench.moment ?? null);
      if (k < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  };

  // Cards come and go with the page; what stands on them is drawn as soon as they are there.
  let waiting = false;
  const soon = () => { if (!waiting) { waiting = true; requestAnimationFrame(() => { waiting = false; bench.fingerprints(); }); } };
  document.addEventListener("DOMContentLoaded", () =>
    new MutationObserver((news) => {
      if (news.some((n) => [...n.addedNodes].some((el) => el.querySelector && (el.matches(".fingerprint") || el.querySelector(".fingerprint"))))) soon();
    }).observe(document.body, { childList: true, subtree: true }));

  // The force that a suspect takes off the map, as a small disc on its card.
  bench.fingerprints = () => {
    const base = S.frames[S.steps[S.present]];
    if (!S.stage || !base) return;
    const colour = mixer(), axes = S.stage.cycle, rows = axes.rows.length - 1, columns = axes.columns.length - 1;
    document.querySelectorAll("canvas.fingerprint").forEach((canvas) => {
      const frame = S.frames[S.suspects[canvas.dataset.effect]], own = canvas.dataset.effect === "";
      const ratio = window.devicePixelRatio || 1, size = canvas.clientWidth || 64, half = size / 2;
      canvas.width = canvas.height = Math.round(size * ratio);
      const c = canvas.getContext("2d", { willReadFrequently: true });
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
      c.strokeStyle = bench.colour("grid"); c.beginPath(); c.arc(half, half, half - 1, 0, TURN); c.stroke();
      if (!frame && !own) {  // its picture is on the way
        c.fillStyle = bench.colour("faint"); c.textAlign = "center"; c.textBaseline = "middle"; c.font = "18px sans-serif"; c.fillText("…", half, half);
        return;
      }
      axes.cells.forEach((code, i) => {
        const left = own ? 0 : frame.cycle[i];
        if (base.cycle[i] === null || left === null) return;
        const row = Math.floor(code / columns), p = axes.columns[code % columns], q = axes.columns[(code % columns) + 1];
        c.fillStyle = c.strokeStyle = colour(base.cycle[i] - left, 0.4 * base.cycle_std[i]);
        c.lineWidth = 0.5; c.beginPath();
        c.arc(half, half, (half - 1) * (row + 1) / rows, p, q); c.arc(half, half, (half - 1) * row / rows, q, p, true);
        c.closePath(); c.fill(); c.stroke();
      });
    });
  };
})();
