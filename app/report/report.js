"use strict";
// Linked zoom and pan, the switch between pictures and error maps, and the wipe; without script the pictures simply stand there.
for (const panel of document.querySelectorAll(".pictures")) {
  const figures = [...panel.querySelectorAll(".grid figure")], wipe = panel.querySelector(".wipe");
  const images = () => panel.querySelectorAll(".view img");
  // Zoom, and the picture's point at the view's left top corner, as a share of its width and height.
  let zoom = 1, left = 0, top = 0, shown = "picture";

  const source = (figure) => {
    const image = figure.querySelector("img");
    return (shown === "error" && image.dataset.error) || image.dataset.picture;
  };
  function place() {
    left = Math.min(Math.max(left, 0), 1 - 1 / zoom);
    top = Math.min(Math.max(top, 0), 1 - 1 / zoom);
    for (const image of images())
      image.style.transform = `scale(${zoom}) translate(${-100 * left}%, ${-100 * top}%)`;
    panel.classList.toggle("zoomed", zoom > 1);
  }
  function zoomAt(factor, x, y) {
    const next = Math.min(Math.max(zoom * factor, 1), 32);
    left += x / zoom - x / next;
    top += y / zoom - y / next;
    zoom = next;
    place();
  }
  function show(what) {
    shown = what;
    for (const figure of figures) figure.querySelector("img").src = source(figure);
    for (const button of panel.querySelectorAll("[data-show]"))
      button.setAttribute("aria-pressed", String(button.dataset.show === what));
    drawWipe();
  }
  function drawWipe() {
    const [below, above] = wipe.querySelectorAll("img");
    below.src = source(figures[wipe.querySelector(".right").value]);
    above.src = source(figures[wipe.querySelector(".left").value]);
    const share = wipe.querySelector("input").value / 10;
    wipe.querySelector(".above").style.clipPath = `inset(0 ${100 - share}% 0 0)`;
    wipe.querySelector(".edge").style.left = `${share}%`;
  }

  for (const view of panel.querySelectorAll(".view")) {
    const at = (event) => {
      const box = view.getBoundingClientRect();
      return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height, box];
    };
    let last = null;
    view.addEventListener("dblclick", (event) => zoomAt(event.shiftKey ? 0.5 : 2, ...at(event)));
    view.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && zoom === 1) return;
      event.preventDefault();
      zoomAt(Math.exp(-event.deltaY * 0.004), ...at(event));
    }, { passive: false });
    view.addEventListener("pointerdown", (event) => {
      if (zoom === 1) return;
      last = event;
      view.setPointerCapture(event.pointerId);
    });
    view.addEventListener("pointermove", (event) => {
      if (!last) return;
      const box = view.getBoundingClientRect();
      left -= (event.clientX - last.clientX) / box.width / zoom;
      top -= (event.clientY - last.clientY) / box.height / zoom;
      last = event;
      place();
    });
    for (const end of ["pointerup", "pointercancel"]) view.addEventListener(end, () => { last = null; });
  }
  for (const button of panel.querySelectorAll("[data-show]"))
    button.addEventListener("click", () => show(button.dataset.show));
  for (const button of panel.querySelectorAll("[data-zoom]"))
    button.addEventListener("click", () => {
      if (button.dataset.zoom === "reset") { zoom = 1; place(); }
      else zoomAt(button.dataset.zoom === "in" ? 2 : 0.5, 0.5, 0.5);
    });
  for (const control of wipe.querySelectorAll("select, input")) control.addEventListener("input", drawWipe);
  panel.querySelector(".tools").hidden = false;
  wipe.hidden = figures.length < 2;
  drawWipe();
}
