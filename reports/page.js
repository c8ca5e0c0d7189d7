(function () {
  "use strict";
  var plots = document.querySelectorAll("script[type='application/json'][data-plot]");
  plots.forEach(function (holder) {
    var target = document.getElementById(holder.dataset.plot);
    vegaEmbed(target, JSON.parse(holder.textContent), {
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
