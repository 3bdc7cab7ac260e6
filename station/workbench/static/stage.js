// The stage: one map of the missing force, measurement and model, what is left. Pointing at a suspect shows the frame of the
// model with it; the frames were computed before, so nothing is asked of the server.
(() => {
  const bench = (window.bench = window.bench || {});
  const S = (bench.state = {
    stage: null, frames: {}, steps: [], present: 0, suspects: {}, says: {}, names: {}, film: null, preview: null, pinned: null,
    trial: null, map: "plane", channel: 0, fitScale: false, zoom: null,
  });
  const plots = (bench.plots = {});
  const frameOf = (id) => (id && S.frames[id]) || null;
  const filmAt = () => (S.film === null ? S.present : S.film);
  bench.previewed = () => S.preview || S.pinned;

  bench.shown = () => {
    const wanted = bench.previewed();
    if (wanted && frameOf(S.suspects[wanted])) return frameOf(S.suspects[wanted]);
    if (S.trial) return S.trial;
    return frameOf(S.steps[filmAt()]) || frameOf(S.steps[S.present]);
  };
  bench.ghost = () => {
    if ((bench.previewed() && frameOf(S.suspects[bench.previewed()])) || S.trial) return frameOf(S.steps[S.present]);
    return filmAt() > 0 ? frameOf(S.steps[filmAt() - 1]) : null;
  };
  const first = () => frameOf(S.steps[0]) || bench.shown();

  // What the server sends: only what changed.
  bench.receive = (news) => {
    if (news.stage) {
      const before = S.stage;
      S.stage = news.stage; S.frames = {}; S.film = S.preview = S.pinned = S.trial = S.zoom = null;
      bench.keepMoments(before);
    }
    Object.assign(S.frames, news.frames || {});
    const another = news.steps && (news.present !== S.present || news.steps.join() !== S.steps.join());
    for (const key of ["suspects", "says", "names"])
      if (news[key]) S[key] = !another && "(own)" in S[key] ? { ...news[key], "(own)": S[key]["(own)"] } : news[key];
    if (news.steps) S.steps = news.steps;
    if (another) { S.present = news.present; S.film = S.trial = null; }  // what is looked at stays while further pictures come
    if (another || news.busy === false) S.pinned = null;
    if (news.trial !== undefined) S.trial = news.trial;
    if (news.preview !== undefined) S.preview = news.preview;
    if (S.preview && !S.suspects[S.preview]) S.preview = null;
    bench.worst();
    bench.draw();
    bench.fingerprints();
  };
  bench.worst = () => {
    const frame = S.stage && first();
    if (!frame) return;
    S.reach = bench.reach(frame.cycle, 0.98);  // colours are those of the first model, whatever is shown
    if (S.chosen === S.stage) return;
    const misfit = (k) => {
      const left = frame.left[k].filter((x) => x !== null), s = S.stage.traces[k].sigma;
      return left.reduce((sum, x) => sum + x * x, 0) / (left.length * s * s || 1);
    };
    S.channel = S.stage.traces.map((_, k) => k).sort((a, b) => misfit(b) - misfit(a))[0];
    S.chosen = S.stage;
  };

  function plot(name, margins) {
    const host = document.querySelector(`[data-plot=${name}]`);
    if (!host) return null;
    if (!plots[name] || plots[name].host !== host) {
      plots[name] = new bench.Plot(host, margins);
      plots[name].redraw = () => bench.draw();
    }
    return plots[name].alive ? plots[name] : null;
  }

  bench.draw = () => {
    const frame = bench.shown();
    if (!S.stage || !frame) return;
    const map = plot("map", { left: 58, right: 74, top: 20, bottom: 34 });
    if (map) bench.drawMap(map, frame, S.stage);
    const over = plot("overlay", { bottom: 4 }), left = plot("left", { bottom: 32 });
    if (over) overlay(over, frame, S.stage);
    if (left) residual(left, frame, S.stage);
    bench.say();
    bench.mark(bench.moment ?? null);
    bench.drawCursors && bench.drawCursors();
  };

  bench.span = () => S.zoom || [Math.min(0, S.stage.time[0]), S.stage.time[S.stage.time.length - 1]];

  function overlay(p, frame, stage) {
    const trace = stage.traces[S.channel], reach = 1.06 * bench.reach(trace.values);
    p.begin(bench.span(), [-reach, reach], ["time since the release [s]", `${trace.channel} [${trace.unit}]`]);
    p.axes({ hideX: true });
    p.line(stage.time, trace.values, bench.colour("ink"), 2.6, 0.9);
    p.line(stage.time, frame.model[S.channel], bench.colour("model"), 1.3);
    p.legend([["measured", bench.colour("ink"), 4], ["model, run freely", bench.colour("model"), 3]]);
  }

  function residual(p, frame, stage) {
    const trace = stage.traces[S.channel], base = first(), ghost = bench.ghost();
    const reach = Math.max(1.1 * bench.reach((S.fitScale ? frame : base).left[S.channel]), 3 * trace.sigma);
    p.begin(bench.span(), [-reach, reach], ["time since the release [s]", `residual [${trace.fine_unit}]`]);
    p.axes();
    if (ghost) p.line(stage.time, ghost.left[S.channel], bench.colour("ghost"), 1);
    p.line(stage.time, frame.left[S.channel], bench.colour("left"), 1.2);
    p.band(-2 * trace.sigma, 2 * trace.sigma, bench.colour("noise"));
    const words = [["now", bench.colour("left"), 3], ["noise (2 std)", bench.colour("noise"), 8]];
    if (ghost) words.unshift(["before", bench.colour("ghost"), 3]);
    p.legend(words);
  }

  // The sentence above, and the ghost on the ladder.
  bench.say = () => {
    const wanted = bench.previewed(), found = wanted && S.suspects[wanted] ? wanted : null;
    const says = S.trial && !found ? S.trial.says : found ? S.says[found] : S.says["step" + filmAt()];
    const place = document.getElementById("statement");
    if (place && says) {
      place.dataset.kind = S.trial && !found ? "trial" : found ? "preview" : S.film !== null && S.film !== S.present ? "film" : says.floor ? "floor" : "present";
      place.querySelector(".big").textContent = says.big;
      place.querySelector(".what").textContent = says.what;
      place.querySelector(".more").textContent = says.more;
    }
    const row = document.getElementById("ghost-step");
    if (row) {
      row.classList.toggle("shown", !!found);
      row.querySelector(".what").textContent = found ? "with " + S.names[found] : "(point at a card)";
      row.querySelector(".value").textContent = found ? S.says[found].times : "";
      row.querySelector(".fill").style.width = found ? S.says[found].share + "%" : "0";
    }
    document.querySelectorAll(".card-suspect").forEach((el) => el.classList.toggle("pointed", el.dataset.preview === found));
    document.querySelectorAll(".step").forEach((el, i) => el.classList.toggle("looked", i === filmAt() && !found));
    const film = document.getElementById("film");
    if (film && document.activeElement !== film) film.value = filmAt();
    const words = document.getElementById("film-words");
    if (words) words.textContent = S.film === null || S.film === S.present ? "" : `looking at step ${S.film}`;
  };

  // An expression of the user's own, fitted: it is shown at once, and again when its card is pointed at.
  bench.own = (found) => {
    delete S.suspects["(own)"];
    if (found) {
      S.frames["(own)"] = found.frame; S.suspects["(own)"] = "(own)"; S.says["(own)"] = found.says; S.names["(own)"] = found.name;
      S.preview = "(own)";
    } else if (S.preview === "(own)") S.preview = null;
    bench.fade();
    bench.say();
  };

  bench.filmTo = (n) => { S.film = Number(n) === S.present ? null : Number(n); bench.fade(); };

  // Preview by pointer and by focus, without the server.
  function preview(name) {
    if (S.preview === name) return;
    const begin = performance.now();
    S.preview = name;
    bench.fade();
    bench.previewTook = performance.now() - begin;
  }
  const target = (event) => event.target.closest && event.target.closest("[data-preview]");
  let at = null;  // where the pointer was last: cards that slide under a resting one are not pointed at
  document.addEventListener("mousemove", (event) => {
    const here = `${event.screenX} ${event.screenY}`, moved = at !== null && at !== here, el = target(event);
    at = here;
    if (!moved) return;
    if (el) preview(el.dataset.preview);
    else if (S.preview && !(document.activeElement && document.activeElement.dataset.preview === S.preview)) preview(null);
  });
  document.addEventListener("focusin", (event) => { const el = target(event); preview(el && el.matches(":focus-visible") ? el.dataset.preview : null); });
  document.addEventListener("focusout", (event) => { if (target(event)) preview(null); });
  document.addEventListener("click", (event) => {
    const el = target(event);
    if (el && el.dataset.commits && S.suspects[el.dataset.preview]) { S.pinned = el.dataset.preview; bench.draw(); }
  });
  document.addEventListener("input", (event) => { if (event.target.id === "film") bench.filmTo(event.target.value); });
})();
