// What the page needs of the browser beside its pictures: the colour scheme, and commands for the keyboard.
document.documentElement.lang = "en";
(() => {
  const bench = (window.bench = window.bench || {});

  bench.dark = () => {
    const kept = localStorage.getItem("bench-theme");
    return kept ? kept === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  };
  bench.keepTheme = (dark) => localStorage.setItem("bench-theme", dark ? "dark" : "light");
  bench.redraw = () => requestAnimationFrame(() => { bench.draw(); bench.fingerprints(); });

  bench.choose = (key, value) => { bench.state[key] = value; bench.draw(); };

  // Rerun's viewer says when it has started.
  window.addEventListener("message", (event) => {
    if (event.origin === location.origin && event.data === "READY") document.querySelectorAll(".viewer-wait").forEach((el) => (el.style.display = "none"));
  });

  // A record that allows no analysis, as it is.
  bench.raw = (traces) => requestAnimationFrame(() => traces.forEach((trace, k) => {
    const host = document.querySelector(`[data-plot=raw${k}]`);
    if (!host) return;
    const plot = new bench.Plot(host, { bottom: 32 }), seen = trace.values.filter((y) => y !== null);
    const low = Math.min(...seen), high = Math.max(...seen), room = 0.06 * (high - low) || 1;
    plot.redraw = () => {
      plot.begin([trace.time[0], trace.time[trace.time.length - 1]], [low - room, high + room], ["time since the start of the record [s]", `${trace.channel} [${trace.unit}]`]);
      plot.axes();
      plot.line(trace.time, trace.values, bench.colour("left"), 1.2);
    };
    plot.redraw();
  }));

  // Names for those who do not see the signs on a library's buttons.
  const NAMES = { ".q-uploader .q-btn": "Choose files to import", ".q-uploader__input": "Files to import", ".q-loading-bar": "Loading", "[role=progressbar]": "Progress" };
  const name = () => {
    for (const [what, words] of Object.entries(NAMES))
      document.querySelectorAll(`${what}:not([aria-label])`).forEach((el) => el.setAttribute("aria-label", words));
  };
  document.addEventListener("DOMContentLoaded", () => { name(); new MutationObserver(name).observe(document.body, { childList: true, subtree: true }); });

  // From card to card with the arrows.
  document.addEventListener("keydown", (event) => {
    const card = document.activeElement && document.activeElement.closest(".card-suspect");
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!card || !step || event.target.tagName === "INPUT") return;
    const cards = [...document.querySelectorAll(".card-suspect")], next = cards[cards.indexOf(card) + step];
    if (next) { event.preventDefault(); next.focus(); next.scrollIntoView({ block: "nearest", inline: "nearest" }); }
  });

  bench.turnRail = () => {
    const open = document.getElementById("columns").classList.toggle("rail-open");
    document.querySelector(".rail-button").setAttribute("aria-expanded", open);
    if (open) document.querySelector("#rail a, #rail button, #rail input")?.focus();
  };

  bench.toExamples = () => {
    const open = document.querySelector("#examples .q-item");
    if (!document.getElementById("columns").classList.contains("rail-open") && !document.getElementById("rail").offsetParent) bench.turnRail();
    if (open && open.getAttribute("aria-expanded") !== "true") open.click();
    setTimeout(() => { const first = document.querySelector("#examples .q-btn"); if (first) { first.scrollIntoView({ block: "nearest" }); first.focus(); } }, 350);
  };
  const closeRail = () => document.querySelector(".rail-open") && bench.turnRail();
  document.addEventListener("mousedown", (event) => { if (!event.target.closest("#rail, .rail-button, .q-menu")) closeRail(); });
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") closeRail(); });

  // The address of what is shown: the session and the step.
  bench.address = () => {
    const here = new URL(location.href), S = bench.state;
    if (S.stage) here.searchParams.set("step", S.film === null ? S.present : S.film);
    return here.href;
  };

  bench.copy = async (text) => {
    try { await navigator.clipboard.writeText(text); return true; } catch { return false; }
  };
})();
