// A picture on a canvas: margins, axes with units, lines and bands. Its scales are given, so that they stay while models change.
(() => {
  const bench = (window.bench = window.bench || {});
  bench.colour = (name) => getComputedStyle(document.body).getPropertyValue("--" + name).trim();
  bench.rgb = (name) => bench.colour(name).match(/[0-9a-f]{2}/gi).map((h) => parseInt(h, 16));

  function ticks(low, high, most) {
    const rough = (high - low) / Math.max(most, 1), power = 10 ** Math.floor(Math.log10(rough));
    const steps = [0.5, 1, 2, 5, 10].map((m) => m * power), first = Math.max(1, steps.findIndex((s) => s >= rough * 0.999));
    let step, found;
    for (let k = first; k >= first - 1; k--) {  // finer where fewer than three numbers would stand at the axis
      step = steps[k]; found = [];
      for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
      if (found.length > 2) break;
    }
    return [found, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))];
  }
  const written = (value, places) => {
    const size = Math.abs(value);
    if (size >= 1e5 || (size && places > 4)) return value.toExponential(1).replace("e+", "e");
    return (Object.is(value, -0) ? 0 : value).toFixed(places).replace("-", "\u2212");
  };
  bench.reach = (values, share = 1) => {
    const sizes = values.filter((v) => v !== null && isFinite(v)).map(Math.abs).sort((a, b) => a - b);
    return sizes.length ? sizes[Math.floor(share * (sizes.length - 1))] || 1e-12 : 1;
  };

  class Plot {
    constructor(host, margins) {
      this.host = host;
      this.margins = { left: 56, right: 10, top: 18, bottom: 20, ...margins };
      this.canvas = document.createElement("canvas");
      this.canvas.setAttribute("aria-hidden", "true");
      host.prepend(this.canvas);
      this.redraw = () => {};
      this.watch = new ResizeObserver(() => this.redraw());
      this.watch.observe(host);
    }
    get alive() { return this.host.isConnected && this.host.clientWidth > 0; }
    begin(x, y, names) {
      const ratio = window.devicePixelRatio || 1, w = this.host.clientWidth, h = this.host.clientHeight;
      if (this.canvas.width !== Math.round(w * ratio) || this.canvas.height !== Math.round(h * ratio)) {
        this.canvas.width = Math.round(w * ratio); this.canvas.height = Math.round(h * ratio);
        this.canvas.style.width = w + "px"; this.canvas.style.height = h + "px";
      }
      const c = (this.c = this.canvas.getContext("2d", { willReadFrequently: true }));  // kept in memory: a virtual graphics card draws slowly
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
      c.clearRect(0, 0, w, h);
      const m = this.margins;
      this.box = { x: m.left, y: m.top, w: Math.max(1, w - m.left - m.right), h: Math.max(1, h - m.top - m.bottom) };
      this.x = x; this.y = y; this.names = names;
    }
    px(x) { return this.box.x + ((x - this.x[0]) / (this.x[1] - this.x[0])) * this.box.w; }
    py(y) { return this.box.y + (1 - (y - this.y[0]) / (this.y[1] - this.y[0])) * this.box.h; }
    at(px, py) {
      const b = this.box;
      if (!b || px < b.x - 1 || px > b.x + b.w + 1 || py < b.y - 1 || py > b.y + b.h + 1) return null;
      return [this.x[0] + ((px - b.x) / b.w) * (this.x[1] - this.x[0]), this.y[1] - ((py - b.y) / b.h) * (this.y[1] - this.y[0])];
    }
    axes({ xTicks = null, yTicks = null, hideX = false } = {}) {
      const { c, box: b } = this;
      c.font = "11px " + getComputedStyle(document.body).fontFamily;
      c.lineWidth = 1;
      const [ys, yp] = yTicks ? [yTicks.map((t) => t[0]), 0] : ticks(this.y[0], this.y[1], Math.max(3, b.h / (b.h > 240 ? 46 : 30)));
      c.textBaseline = "middle"; c.textAlign = "right";
      ys.forEach((y, i) => {
        const at = Math.round(this.py(y)) + 0.5;
        c.strokeStyle = bench.colour("grid"); c.beginPath(); c.moveTo(b.x, at); c.lineTo(b.x + b.w, at); c.stroke();
        c.fillStyle = bench.colour("faint"); c.fillText(yTicks ? yTicks[i][1] : written(y, yp), b.x - 5, at);
      });
      const [xs, xp] = xTicks ? [xTicks.map((t) => t[0]), 0] : ticks(this.x[0], this.x[1], Math.max(2, b.w / 52));
      c.textAlign = "center"; c.textBaseline = "top";
      xs.forEach((x, i) => {
        const at = Math.round(this.px(x)) + 0.5;
        c.strokeStyle = bench.colour("grid"); c.beginPath(); c.moveTo(at, b.y); c.lineTo(at, b.y + b.h); c.stroke();
        if (hideX) return;
        c.fillStyle = bench.colour("faint"); c.fillText(xTicks ? xTicks[i][1] : written(x, xp), at, b.y + b.h + 4);
      });
      c.strokeStyle = bench.colour("faint"); c.strokeRect(b.x + 0.5, b.y + 0.5, b.w - 1, b.h - 1);
      c.fillStyle = bench.colour("ink"); c.textAlign = "left"; c.textBaseline = "alphabetic";
      c.fillText(this.names[1], 4, 12);
      if (!hideX) { c.textAlign = "right"; c.fillText(this.names[0], b.x + b.w, b.y + b.h + this.margins.bottom - 3); }
    }
    clip(draws) {
      const { c, box: b } = this;
      c.save(); c.beginPath(); c.rect(b.x, b.y, b.w, b.h); c.clip(); draws(c); c.restore();
    }
    line(xs, ys, colour, width, alpha = 1) {
      this.clip((c) => {
        c.strokeStyle = colour; c.lineWidth = width; c.globalAlpha = alpha; c.lineJoin = "round"; c.beginPath();
        let down = false;
        for (let i = 0; i < xs.length; i++) {
          if (ys[i] === null || xs[i] < this.x[0] || xs[i] > this.x[1]) {
            if (ys[i] === null || !down) { down = false; if (ys[i] === null || xs[i + 1] < this.x[0] || xs[i] > this.x[1]) continue; }
          }
          const x = this.px(xs[i]), y = this.py(ys[i]);
          if (down) c.lineTo(x, y); else c.moveTo(x, y);
          down = true;
        }
        c.stroke();
      });
    }
    band(low, high, colour) {
      this.clip((c) => {
        c.fillStyle = colour;
        const top = this.py(high), bottom = this.py(low);
        c.fillRect(this.box.x, top - 0.5, this.box.w, Math.max(1.5, bottom - top + 1));
      });
    }
    legend(entries) {
      const { c, box: b } = this;
      let x = b.x + b.w;
      c.font = "11px " + getComputedStyle(document.body).fontFamily; c.textBaseline = "middle"; c.textAlign = "right";
      for (const [words, colour, height, alpha] of [...entries].reverse()) {
        c.fillStyle = bench.colour("ink"); c.fillText(words, x, 9);
        x -= c.measureText(words).width + 20;
        c.globalAlpha = alpha ?? 1; c.fillStyle = colour; c.fillRect(x, 9 - height / 2, 14, height); c.globalAlpha = 1;
        x -= 10;
      }
    }
  }
  bench.Plot = Plot;
})();
