// What the page needs of the browser beside its pictures: the colour scheme, and commands for the keyboard.
(() => {
  const bench = (window.bench = window.bench || {});

  bench.dark = () => {
    const kept = localStorage.getItem("bench-theme");
    return kept ? kept === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  };
  bench.keepTheme = (dark) => localStorage.setItem("bench-theme", dark ? "dark" : "light");
  bench.redraw = () => requestAnimationFrame(() => { bench.draw(); bench.fingerprints(); });

  bench.choose = (key, value) => { bench.state[key] = value; bench.draw(); };

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

  // The address of what is shown: the session and the rung.
  bench.address = () => {
    const here = new URL(location.href), S = bench.state;
    if (S.stage) here.searchParams.set("rung", S.film === null ? S.present : S.film);
    return here.href;
  };

  bench.copy = async (text) => {
    try { await navigator.clipboard.writeText(text); return true; } catch { return false; }
  };
})();
