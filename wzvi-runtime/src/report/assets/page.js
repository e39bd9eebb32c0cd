// Says which tables scroll, and shows the numbers of the point under the pointer or with the focus.
(() => {
  const fit = () => document.querySelectorAll(".table").forEach((table) => {
    table.previousElementSibling.hidden = table.scrollWidth <= table.clientWidth;
  });
  document.addEventListener("toggle", fit, true);
  addEventListener("resize", fit);
  fit();
  const tip = document.getElementById("tip");
  const hide = () => { tip.hidden = true; };
  const show = (event) => {
    const point = event.target.closest("[data-tip]");
    if (!point) return;
    tip.textContent = point.dataset.tip;
    tip.hidden = false;
    const at = point.getBoundingClientRect(), box = tip.getBoundingClientRect();
    const left = Math.min(at.right + 8, innerWidth - box.width - 8);
    const below = at.bottom + 8 + box.height < innerHeight;
    tip.style.left = Math.max(8, left) + "px";
    tip.style.top = (below ? at.bottom + 8 : Math.max(8, at.top - box.height - 8)) + "px";
  };
  document.addEventListener("pointerover", show);
  document.addEventListener("focusin", show);
  document.addEventListener("pointerout", hide);
  document.addEventListener("focusout", hide);
  document.addEventListener("scroll", hide, true);
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") hide(); });
})();
