(function () {
  "use strict";
  // Shown dark, the charts' inks change places with lighter ones.
  var lighter = { "#1f2933": "#e4e7eb", "#e4e7eb": "#323f4b", "#334155": "#cbd2d9", "#52606d": "#9aa5b1" };
  var dark = window.matchMedia("screen and (prefers-color-scheme: dark)").matches;
  // Vega measures texts before it draws them, by the font's name: with one that it cannot resolve, as "inherit", it leaves
  // too little room for titles, labels and legends.
  var family = getComputedStyle(document.body).fontFamily;
  var pen = document.createElement("canvas").getContext("2d");
  // As many of a legend's names beside each other as there is room for; one that is wider than that is written smaller.
  function fit_legends(node, room) {
    if (node === null || typeof node !== "object") return;
    var names = node.legend && node.scale && node.scale.domain;
    if (Array.isArray(names) && names.every(function (name) { return typeof name === "string"; })) {
      pen.font = "12px " + family;
      var symbol = 28, widest = Math.max.apply(null, names.map(function (name) { return pen.measureText(name).width; }));
      node.legend.columns = Math.max(1, Math.min(names.length, Math.floor(room / (widest + symbol))));
      if (widest + symbol > room) node.legend.labelFontSize = Math.max(7, 12 * (room - symbol) / widest);
    }
    Object.keys(node).forEach(function (key) { if (key !== "values") fit_legends(node[key], room); });
  }
  function specification(text, width) {
    var spec = JSON.parse(dark ? text.replace(/#[0-9a-f]{6}/g, function (ink) { return lighter[ink] || ink; }) : text);
    spec.config.font = family;
    var beside = 80; // the axis' labels, and the button in the corner
    fit_legends(spec, width - beside);
    return spec;
  }
  var plots = document.querySelectorAll("script[type='application/json'][data-plot]");
  // Those in view are drawn at once, the others one after another when there is nothing else to do: a page of many charts
  // opens as soon as one of few.
  var waiting = Array.prototype.slice.call(plots);
  function draw(holder) {
    var target = document.getElementById(holder.dataset.plot);
    waiting.splice(waiting.indexOf(holder), 1);
    return vegaEmbed(target, specification(holder.textContent, target.clientWidth || 700), {
      renderer: "svg",
      actions: { export: { svg: true, png: true }, source: false, compiled: false, editor: false },
      downloadFileName: holder.dataset.plot
    }).then(function () { document.body.dataset.drawn = Number(document.body.dataset.drawn || 0) + 1; },
            function (error) { target.textContent = "This chart could not be drawn: " + error.message; target.className += " bad"; });
  }
  function later(work) {
    if (window.requestIdleCallback) requestIdleCallback(work, { timeout: 200 });
    else setTimeout(work, 20);
  }
  function draw_next() { if (waiting.length) draw(waiting[0]).then(function () { later(draw_next); }); }
  function in_view(holder) {
    var box = document.getElementById(holder.dataset.plot).getBoundingClientRect();
    return box.top < window.innerHeight && box.bottom > 0;
  }
  function draw_seen() { waiting.filter(in_view).forEach(draw); }
  draw_seen();
  window.addEventListener("scroll", draw_seen, { passive: true });
  window.addEventListener("beforeprint", function () { waiting.slice().forEach(draw); });
  later(draw_next);
  // The first two pictures of a group, one over the other: a slider between them, and a button that shows them in turns.
  document.querySelectorAll("[data-pair]").forEach(function (group) {
    var pictures = group.querySelectorAll("figure img");
    if (pictures.length < 2) return;
    var pair = document.createElement("div");
    pair.className = "pair";
    pair.innerHTML = '<div class="lay"></div><div class="bar"><button type="button">flip</button>' +
      '<input type="range" min="0" max="100" value="50" aria-label="how much of the second picture is laid over the first"></div>';
    var under = pictures[0].cloneNode(), over = pictures[1].cloneNode();
    over.className = "over";
    pair.firstChild.append(under, over);
    var slider = pair.querySelector("input"), timer = null;
    function cut() { over.style.clipPath = "inset(0 0 0 " + slider.value + "%)"; }
    function still() { clearInterval(timer); timer = null; over.classList.remove("hide"); cut(); }
    slider.addEventListener("input", still);
    pair.querySelector("button").addEventListener("click", function () {
      if (timer) return still();
      over.style.clipPath = "none";
      timer = setInterval(function () { over.classList.toggle("hide"); }, 500);
    });
    var amplified = group.querySelector("[data-amplified]");
    if (amplified) {
      var more = document.createElement("button"), shown = false, difference = amplified.querySelector("img").cloneNode();
      more.type = "button";
      more.textContent = "difference × " + amplified.dataset.amplified;
      difference.className = "over hide";
      pair.firstChild.append(difference);
      more.addEventListener("click", function () {
        shown = !shown;
        difference.classList.toggle("hide", !shown);
        more.setAttribute("aria-pressed", String(shown));
      });
      pair.querySelector("button").after(more);
    }
    cut();
    group.after(pair);
  });
  document.addEventListener("click", function (event) {
    if (event.target.matches("figure img")) event.target.classList.toggle("open");
  });
  document.addEventListener("keydown", function (event) {
    if (event.key === "Escape") document.querySelectorAll("img.open").forEach(function (image) { image.classList.remove("open"); });
  });
})();
