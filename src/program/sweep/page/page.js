"use strict";
const views = [...document.querySelectorAll("section")];
const links = [...document.querySelectorAll(".sheet a")];
const slider = document.querySelector("nav input");
const label = document.querySelector("nav output");
let current = 0;

function show(at) {
  current = Math.min(Math.max(at, 0), views.length - 1);
  views.forEach((view, k) => { view.hidden = k !== current; });
  links.forEach((link, k) => { link.classList.toggle("current", k === current); });
  slider.value = current;
  label.textContent = views[current] ? views[current].dataset.title : "";
}

// Each view has its address.
function go(at) {
  show(at);
  history.replaceState(null, "", `#${views[current].id}`);
}

links.forEach((link, at) => {
  link.querySelector("img").src = views[at].querySelector("img").src;
});
function showAddressed() {
  show(Math.max(0, views.findIndex((view) => `#${view.id}` === decodeURIComponent(location.hash))));
}

links.forEach((link, at) => link.addEventListener("click", (event) => {
  event.preventDefault();
  go(at);
}));
addEventListener("hashchange", showAddressed);
slider.addEventListener("input", () => go(Number(slider.value)));
// Arrow keys, wherever the focus is.
const steps = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };
addEventListener("keydown", (event) => {
  if (event.altKey || event.ctrlKey || event.metaKey) return;
  const ends = { Home: 0, End: views.length - 1 };
  const target = event.key in ends ? ends[event.key] : current + (steps[event.key] || NaN);
  if (!Number.isNaN(target)) {
    event.preventDefault();
    go(target);
  }
});

// Luminance under the pointer, from the colors of its picture: within half a color of 256.
const places = new Map(lampyrisColors.map((color, k) => [color.join(), k]));
const pixels = new WeakMap();
function pixelsOf(image) {
  if (!pixels.has(image)) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    pixels.set(image, context);
  }
  return pixels.get(image);
}

function reading(box, image, x, y) {
  const place = places.get([...pixelsOf(image).getImageData(x, y, 1, 1).data].slice(0, 3).join());
  if (place === undefined) return "–";
  const [low, high] = [Number(box.dataset.low), Number(box.dataset.high)];
  const value = low * (high / low) ** (place / (lampyrisColors.length - 1));
  const sign = place === 0 ? "≤ " : place === lampyrisColors.length - 1 ? "≥ " : "";
  return `${sign}${value.toPrecision(3)}${box.dataset.unit}`;
}

views.forEach((view) => {
  const box = view.querySelector(".luminance");
  const image = box.querySelector("img");
  const text = view.querySelector(".reading");
  view.querySelectorAll(".picture").forEach((picture) => {
    picture.addEventListener("pointermove", (event) => {
      const frame = picture.getBoundingClientRect();
      const at = (share, count) => Math.min(Math.max(Math.floor(share * count), 0), count - 1);
      const x = at((event.clientX - frame.left) / frame.width, image.naturalWidth);
      const y = at((event.clientY - frame.top) / frame.height, image.naturalHeight);
      text.textContent =
        `luminance under the pointer, x = ${x}, y = ${y}: ${reading(box, image, x, y)}`;
    });
  });
});

if (typeof lampyrisTimings === "object") {
  views.forEach((view) => {
    const seconds = lampyrisTimings[view.id];
    if (seconds !== undefined) {
      view.querySelector(".seconds").textContent = `${seconds.toFixed(2)} s`;
    }
  });
}
showAddressed();
