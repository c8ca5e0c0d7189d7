(function () {
  "use strict";
  // Shown dark, the charts' inks change places with lighter ones.
  var lighter = { "#1f2933": "#e4e7eb", "#e4e7eb": "#323f4b", "#334155": "#cbd2d9", "#52606d": "#9aa5b1" };
  var dark = window.matchMedia("screen and (prefers-color-scheme: dark)").matches;
  function specification(text) {
    return JSON.parse(dark ? text.replace(/#[0-9a-f]{6}/g, function (ink) { return lighter[ink] || ink; }) : text);
  }
  var plots = document.querySelectorAll("script[type='application/json'][data-plot]");
  plots.forEach(function (holder) {
    var target = document.getElementById(holder.dataset.plot);
    vegaEmbed(target, specification(holder.textContent), {
      renderer: "svg",
      actions: { export: { svg: true, png: true }, source: false, compiled: false, editor: false },
      downloadFileName: holder.dataset.plot
    }).then(function () { document.body.dataset.drawn = Number(document.body.dataset.drawn || 0) + 1; },
            function (error) { target.textContent = "This chart could not be drawn: " + error.message; target.className += " bad"; });
  });
  document.addEventListener("click", function (event) {
    if (event.target.matches("figure img")) event.target.classList.toggle("open");
  });
  document.addEventListener("keydown", function (event) {
    if (event.key === "Escape") document.querySelectorAll("img.open").forEach(function (image) { image.classList.remove("open"); });
  });
})();
