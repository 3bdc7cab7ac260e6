// The stage: the force that the model lacks, before and after, and measurement and model over time. Frames were computed
// before, so pointing at a suspect asks nothing of the server.
(() => {
  const bench = (window.bench = window.bench || {}), SURE = [1.6, 2.6], NONE = [];
  const S = (bench.state = { stage: null, frames: {}, steps: [], present: 0, suspects: {}, says: {}, names: {}, best: null, film: null, asked: new URLSearchParams(location.search).get("step"), pointed: null, selected: null, channel: 0 });
  const frameOf = (id) => (id && S.frames[id]) || null, filmAt = () => (S.film === null ? S.present : S.film);
  bench.previewed = () => [S.pointed, S.selected].find((name) => name && frameOf(S.suspects[name])) || null;
  bench.shown = () => frameOf(S.suspects[bench.previewed()]) || frameOf(S.steps[filmAt()]) || frameOf(S.steps[S.present]);
  bench.before = () => (bench.previewed() ? frameOf(S.steps[S.present]) : filmAt() > 0 ? frameOf(S.steps[filmAt() - 1]) : null);
  const first = () => frameOf(S.steps[0]) || bench.shown();

  // What the server sends: only what changed.
  bench.receive = (news) => {
    if (news.stage) { S.stage = news.stage; S.frames = {}; S.film = S.pointed = S.selected = null; }
    Object.assign(S.frames, news.frames || {});
    const another = news.steps && (news.present !== S.present || news.steps.join() !== S.steps.join()), own = S.says["(own)"];
    for (const key of ["suspects", "says", "names"])
      if (news[key]) S[key] = !another && own && "(own)" in S[key] ? { ...news[key], "(own)": S[key]["(own)"] } : news[key];
    // What is looked at stays while further pictures come; a step that one has gone to is shown itself, though its best suspect is known.
    if (another) { S.best = S.steps.length ? news.best : null; S.present = news.present; S.film = S.selected = null; }
    if (news.steps) S.steps = news.steps;
    if (news.best !== undefined && news.best !== S.best && frameOf(S.suspects[news.best])) S.selected = S.best = news.best;
    // The step of the address, which one looked at before the page was loaded again.
    if (S.asked !== null && frameOf(S.steps[S.asked])) { S.film = Number(S.asked) === S.present ? null : Number(S.asked); S.asked = null; }
    if (S.stage && S.scaled !== S.stage) { S.scaled = S.stage; S.channel = worst(); }
    if (S.stage && first()) S.reach = reachOf(first());  // colours are those of the first model, whatever is shown
    bench.draw();
    setTimeout(bench.draw, 300);  // cards, buttons and the width of a chart may come a moment after what is said of them
  };
  bench.choose = (key, value) => { S[key] = value; bench.draw(); };
  bench.select = (name) => { S.selected = name; bench.draw(); };
  bench.filmTo = (n) => { S.film = Number(n) === S.present ? null : Number(n); S.selected = null; bench.draw(); };
  // An expression of the user's own, fitted: it is shown at once.
  bench.own = (found) => {
    delete S.suspects["(own)"];
    if (found) { S.frames["(own)"] = found.frame; S.suspects["(own)"] = "(own)"; S.says["(own)"] = found.says; S.names["(own)"] = found.name; S.selected = "(own)"; }
    else if (S.selected === "(own)") S.selected = null;
    bench.draw();
  };

  const size = (values) => values.reduce((most, v) => Math.max(most, Math.abs(v)), 1e-12);
  // The force at the end of the colours: 98 % of the cells are below it, each counted as sure as it is known.
  function reachOf(frame) {
    const known = frame.force.map((force, i) => [Math.abs(force), frame.force_std[i] ** -2]);
    let left = 0.98 * known.reduce((sum, [, sure]) => sum + sure, 0);
    return (known.sort((a, b) => a[0] - b[0]).find(([, sure]) => (left -= sure) <= 0) || [1])[0] || 1e-12;
  }
  function worst() {  // the channel in which the first model fails most
    const frame = first(), of = (k) => { const left = frame.left[k].filter((x) => x !== null); return left.reduce((sum, x) => sum + x * x, 0) / (left.length * frame.noise[k] ** 2 || 1); };
    return frame ? S.stage.traces.map((_, k) => k).sort((a, b) => of(b) - of(a))[0] : 0;
  }
  // A cell's colour: the force, less the sure it is; grey within the noise.
  const stained = (frame) => frame ? frame.force.map((force, i) => {
    const sure = Math.min(1, Math.max(0, (Math.abs(force) / frame.force_std[i] - SURE[0]) / (SURE[1] - SURE[0])));
    return [frame.cells[i][0], frame.cells[i][2], sure * force, i];
  }) : NONE;
  const cellOf = (frame) => (_, api) => {
    const [left, right, low, high] = frame.cells[api.value(3)], [x, y] = api.coord([left, high]), [end, bottom] = api.coord([right, low]);
    return { type: "rect", shape: { x, y, width: end - x, height: bottom - y }, style: { fill: api.visual("color"), stroke: api.visual("color"), lineWidth: 0.6 } };
  };

  const axis = (name, grid, { axisLabel, ...more }) => ({ gridIndex: grid, name, nameLocation: "middle", nameGap: 22, nameTextStyle: { color: bench.css("ink"), fontSize: 11 }, axisLine: { show: true, onZero: false, lineStyle: { color: bench.css("faint") } },
    axisLabel: { color: bench.css("faint"), fontSize: 11, hideOverlap: true, showMinLabel: false, showMaxLabel: false, ...axisLabel }, splitLine: { lineStyle: { color: bench.css("grid") } }, splitNumber: 4, ...more });
  const title = (text, left, top = 0, width = undefined) => ({ text, left, top, textStyle: { color: bench.css("ink"), fontSize: 12, fontWeight: 600, width, overflow: "truncate" } });
  const legend = (data, top) => ({ data, right: 4, top, itemWidth: 14, itemHeight: 4, icon: "roundRect", textStyle: { color: bench.css("ink"), fontSize: 11 } });
  bench.axis = axis;

  function map(chart, frame, stage) {
    const before = bench.before(), largest = 1.04 * stage.largest.u, up = 1.04 * stage.largest.v, u = stage.units;
    const maps = before ? [before, frame] : [frame], width = before ? 37 : 82, said = saidOf();
    const words = before ? [`before: ${said.before}`, said.now] : [said.now], places = maps.map((_, k) => 7 + k * 45);
    chart.setOption({ animation: false, textStyle: { fontFamily: bench.font() }, title: words.map((text, k) => title(text, `${places[k]}%`, 0, before ? 0.43 * chart.getWidth() : undefined)),
      grid: maps.map((_, k) => ({ left: `${places[k]}%`, width: `${width}%`, top: 22, bottom: 38 })),
      xAxis: maps.map((_, k) => axis(`displacement [${u.u}]`, k, { type: "value", min: -largest, max: largest })),
      yAxis: maps.map((_, k) => axis(k ? "" : `velocity [${u.v}]`, k, { type: "value", min: -up, max: up, nameGap: 34, axisLabel: { show: !k } })),
      visualMap: { type: "continuous", dimension: 2, min: -S.reach, max: S.reach, right: 0, top: "middle", itemHeight: 90, itemWidth: 10, precision: 2, padding: 0, inRange: { color: ["map-low", "map-middle", "map-high"].map(bench.css) },
        text: ["+", "\u2212"].map((sign) => `${sign}${Number(S.reach.toPrecision(2))} ${u.f}`), textStyle: { color: bench.css("ink"), fontSize: 11 }, hoverLink: false },
      series: maps.map((one, k) => ({ type: "custom", id: k === maps.length - 1 ? "after" : "before", xAxisIndex: k, yAxisIndex: k, silent: true, clip: true, encode: { x: 0, y: 1 }, renderItem: cellOf(one), data: stained(one) })),
    }, { replaceMerge: ["series", "grid", "xAxis", "yAxis", "title"] });
  }

  function traces(chart, frame, stage) {
    const trace = stage.traces[S.channel], before = bench.before(), t = stage.time, pairs = (ys) => ys.map((y, i) => [t[i], y]);
    const line = (id, name, ys, grid, colour, width, more) => ({ id, name, type: "line", xAxisIndex: grid, yAxisIndex: grid, data: pairs(ys), symbol: "none", silent: true, tooltip: { valueFormatter: (y) => (typeof y === "number" ? `${y.toPrecision(4)} ${grid ? trace.fine_unit : trace.unit}` : "?") }, lineStyle: { width, color: bench.css(colour) }, itemStyle: { color: bench.css(colour) }, ...more });
    const reach = Math.max(1.1 * size(first().left[S.channel]), 3 * first().noise[S.channel]), ends = { showMinLabel: null, showMaxLabel: null };
    const time = { type: "value", min: Math.min(0, t[0]), max: t[t.length - 1], axisPointer: { label: { formatter: (p) => `t = ${p.value.toFixed(3)} s` } } }, noise = [-2, 2].map((times) => ({ yAxis: times * frame.noise[S.channel] }));
    chart.setOption({ animation: false, textStyle: { fontFamily: bench.font() },
      title: [title(`${trace.channel} [${trace.unit}]`, 4), title(`residual [${trace.fine_unit}], noise (2 std)`, 4, "46%")],
      legend: [legend(["measured", "model"], 0), legend(before ? ["before", "now"] : ["now"], "46%")],
      grid: [{ left: 52, right: 12, top: 22, height: "30%" }, { left: 52, right: 12, top: "58%", bottom: 34 }],
      xAxis: [axis("", 0, { ...time, axisLabel: { show: false } }), axis("time since the release [s]", 1, time)],
      yAxis: [axis("", 0, { type: "value", scale: true, splitNumber: 2, axisLabel: ends }), axis("", 1, { type: "value", min: -reach, max: reach, interval: reach, axisLabel: { ...ends, formatter: (y) => Number(y.toPrecision(2)).toString() } })],
      axisPointer: { link: [{ xAxisIndex: "all" }] }, dataZoom: [{ type: "inside", xAxisIndex: [0, 1], zoomOnMouseWheel: "ctrl", moveOnMouseMove: "shift" }],
      tooltip: { trigger: "axis", confine: true, backgroundColor: bench.css("paper"), borderColor: bench.css("line"), textStyle: { color: bench.css("ink"), fontSize: 12 } },
      series: [line("measured", "measured", trace.values, 0, "ink", 2.4), line("model", "model", frame.model[S.channel], 0, "model", 1.3),
        line("before", "before", before ? before.left[S.channel] : NONE, 1, "ghost", 1), line("left", "now", frame.left[S.channel], 1, "left", 1.2, { markArea: { silent: true, itemStyle: { color: bench.css("noise") }, data: [noise] } })],
    });
  }

  let waiting = null, drawn = [];
  bench.draw = () => {
    const frame = bench.shown();
    if (!S.stage || !frame) return;
    const places = { map: bench.chart("map"), traces: bench.chart("traces") }, said = saidOf();
    const now = [frame, bench.before(), S.reach, said.before, said.now, S.channel, document.body.className, places.map, places.traces, places.map && places.map.getWidth()];
    if (now.some((part, k) => part !== drawn[k])) {  // words that changed need no new picture
      drawn = now;
      if (places.map) map(places.map, frame, S.stage);
      if (places.traces) traces(places.traces, frame, S.stage);
    }
    say();
    clearTimeout(waiting);
    if (!places.map || !places.traces) waiting = setTimeout(bench.draw, 200);  // a chart that is not there yet, or not looked at
  };

  function saidOf() {
    const found = bench.previewed(), present = S.says["step" + S.present], film = S.says["step" + filmAt()];
    if (found) return { before: present.short, now: S.says[found].short, says: S.says[found] };
    const last = filmAt() > 0 ? S.says["step" + (filmAt() - 1)] : null;
    return { before: last && last.short, now: film.short, says: film };
  }
  function say() {
    if (!S.stage || !bench.shown()) return;
    const found = bench.previewed(), says = saidOf().says, place = document.getElementById("statement"), row = document.getElementById("ghost-step");
    if (place) {
      place.dataset.kind = found ? "preview" : S.film !== null ? "film" : says.floor ? "floor" : "present";
      for (const part of ["big", "what", "more"]) place.querySelector("." + part).textContent = says[part];
    }
    if (row) {
      row.classList.toggle("shown", !!found);
      row.querySelector(".what").textContent = found ? "with " + S.names[found] : "(choose a suspect)";
      row.querySelector(".value").textContent = found ? S.says[found].times : "";
      row.querySelector(".fill").style.width = found ? S.says[found].share + "%" : "0";
    }
    const channel = document.getElementById("channel"), choice = channel && channel.querySelector("select");
    if (channel) {
      if (choice.length !== S.stage.traces.length) choice.replaceChildren(...S.stage.traces.map((trace, k) => new Option(trace.channel, k)));
      channel.hidden = choice.length < 2;
      choice.value = S.channel;
    }
    document.querySelectorAll(".card-suspect").forEach((el) => { const on = el.dataset.preview === S.selected; el.classList.toggle("selected", on); if (el.tagName === "BUTTON") el.setAttribute("aria-pressed", on); el.classList.toggle("pointed", el.dataset.preview === S.pointed); });
    document.querySelectorAll(".step").forEach((el, i) => el.classList.toggle("looked", i === filmAt() && !found));
    const add = document.getElementById("add-selected"), film = document.getElementById("film"), words = document.getElementById("film-words");
    if (add) { add.hidden = S.selected === "(own)"; add.dataset.to = S.selected; add.disabled = !S.names[S.selected]; add.textContent = `Add ${S.names[S.selected] || "what is selected"}`; }
    if (film && document.activeElement !== film) film.value = filmAt();
    if (words) words.textContent = S.film === null ? "" : `looking at step ${S.film}`;
    bench.address();
  }

  // Pointing and focus preview, a click selects; a card that slides under a resting pointer is not pointed at.
  const target = (event) => event.target.closest && event.target.closest("[data-preview]");
  const point = (name) => { if (S.pointed !== name) { S.pointed = name; bench.draw(); } };
  let at = null;
  document.addEventListener("mousemove", (event) => {
    const here = `${event.screenX} ${event.screenY}`, moved = at !== null && at !== here, el = target(event);
    at = here;
    if (moved) point(el ? el.dataset.preview : null);
  });
  document.addEventListener("focusin", (event) => { const el = target(event); point(el && el.matches(":focus-visible") ? el.dataset.preview : null); });
  document.addEventListener("click", (event) => {
    const el = target(event);
    if (el && S.suspects[el.dataset.preview]) bench.select(el.dataset.preview);
    else if (event.target.closest(".step")) bench.select(null);  // the model itself
  });
  document.addEventListener("input", (event) => {
    if (event.target.id === "film") bench.filmTo(event.target.value);
    if (event.target.closest("#channel")) bench.choose("channel", Number(event.target.value));
  });
})();
