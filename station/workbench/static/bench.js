// What the page needs of the browser beside its pictures: the colour scheme, names for what a library leaves nameless, keys.
document.documentElement.lang = "en";
(() => {
  const bench = (window.bench = window.bench || {});
  bench.css = (name) => getComputedStyle(document.body).getPropertyValue("--" + name).trim();
  bench.chart = (name) => { const el = document.querySelector(`[data-plot=${name}]`); return (el && el.clientWidth && getElement(el) && getElement(el).chart) || null; };
  bench.font = () => getComputedStyle(document.body).fontFamily;
  bench.dark = () => {
    const kept = localStorage.getItem("bench-theme");
    return kept ? kept === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  };
  bench.showTheme = () => { setDark(bench.dark()); requestAnimationFrame(() => bench.draw()); };
  bench.turnTheme = () => { localStorage.setItem("bench-theme", bench.dark() ? "light" : "dark"); bench.showTheme(); };

  // The live scope: the newest seconds of the channel that triggers, its zero, its noise, and the swing that is a release.
  bench.scope = (now) => {
    const chart = bench.chart("scope"), zero = now.zero ?? 0;
    if (!chart || !now.points.length) return;
    const reach = Math.max(now.level ? 1.4 * now.level : 1e-9, 1.15 * Math.max(...now.points.map((p) => Math.abs(p[1] - zero))));
    const mark = (y, name, colour, type) => ({ yAxis: y, name, lineStyle: { color: bench.css(colour), type }, label: { formatter: name, color: bench.css(colour) } });
    const marks = [...(now.level ? [mark(zero + now.level, "release", "bad", "dashed"), mark(zero - now.level, "", "bad", "dashed")] : []), ...(now.zero === null ? [] : [mark(zero, now.level > 0.2 * reach ? "zero" : "", "good", "solid")])];
    chart.setOption({ animation: false, textStyle: { fontFamily: bench.font() }, grid: { left: 60, right: 70, top: 26, bottom: 36 }, xAxis: bench.axis("seconds until now [s]", 0, { type: "value", min: -8, max: 0 }),
      yAxis: bench.axis(`${now.channel} [${now.unit}]`, 0, { type: "value", min: zero - reach, max: zero + reach, nameLocation: "end", nameGap: 8, axisLabel: { formatter: (y) => Number(y.toPrecision(3)).toString() } }),
      series: [{ type: "line", symbol: "none", data: now.points, lineStyle: { color: bench.css("left"), width: 1.6 }, silent: true, markLine: { symbol: "none", silent: true, data: marks },
        markArea: { silent: true, itemStyle: { color: bench.css("noise") }, data: now.noise ? [[{ yAxis: zero - 2 * now.noise }, { yAxis: zero + 2 * now.noise }]] : [] } }] });
  };

  bench.stopped = () => document.body.insertAdjacentHTML("beforeend", '<div class="card strong stopped" role="alert">The station was stopped. All is kept in the sessions; start it again to go on.</div>');

  // Rerun's viewer says when it has started.
  window.addEventListener("message", (event) => {
    if (event.origin === location.origin && event.data === "READY") document.querySelectorAll(".viewer-wait").forEach((el) => (el.style.display = "none"));
  });

  // Names for those who do not see the signs on a library's buttons.
  const NAMES = { ".q-uploader .q-btn": "Choose files to import", ".q-uploader__input": "Files to import", ".q-loading-bar": "Loading", "[role=progressbar]": "Progress" };
  const name = () => {
    for (const [what, words] of Object.entries(NAMES))
      document.querySelectorAll(`${what}:not([aria-label])`).forEach((el) => el.setAttribute("aria-label", words));
  };
  document.addEventListener("DOMContentLoaded", () => { name(); new MutationObserver(name).observe(document.body, { childList: true, subtree: true }); });

  // From card to card with the arrows.
  document.addEventListener("keydown", (event) => {
    const card = document.activeElement && document.activeElement.closest(".card-suspect"), step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (event.key === "Escape") closeRail();
    if (!card || !step || event.target.tagName === "INPUT") return;
    const cards = [...document.querySelectorAll(".card-suspect")], next = cards[cards.indexOf(card) + step];
    if (next) { event.preventDefault(); next.focus(); next.scrollIntoView({ block: "nearest", inline: "nearest" }); }
  });

  bench.turnRail = () => {
    const open = document.getElementById("columns").classList.toggle("rail-open");
    document.querySelector(".rail-button").setAttribute("aria-expanded", open);
    if (open) document.querySelector("#rail a, #rail button, #rail input")?.focus();
  };
  const closeRail = () => document.querySelector(".rail-open") && bench.turnRail();
  document.addEventListener("mousedown", (event) => { if (!event.target.closest("#rail, .rail-button, .q-menu")) closeRail(); });

  bench.toExamples = () => {
    const open = document.querySelector("#examples .q-item");
    if (!document.getElementById("columns").classList.contains("rail-open") && !document.getElementById("rail").offsetParent) bench.turnRail();
    if (open && open.getAttribute("aria-expanded") !== "true") open.click();
    setTimeout(() => { const first = document.querySelector("#examples .q-btn"); if (first) { first.scrollIntoView({ block: "nearest" }); first.focus(); } }, 350);
  };

  // The address is that of what is shown: the session, and the step that is looked at.
  bench.address = () => {
    const here = new URL(location.href), S = bench.state;
    if (S.film === null) here.searchParams.delete("step"); else here.searchParams.set("step", S.film);
    if (here.href !== location.href) history.replaceState(history.state, "", here);
  };
})();
