"use strict";
const views = [...document.querySelectorAll("section")];
const links = [...document.querySelectorAll(".sheet a")];
const slider = document.querySelector("nav input");
const label = document.querySelector("nav output");

function show(at) {
  views.forEach((view, k) => { view.hidden = k !== at; });
  links.forEach((link, k) => { link.classList.toggle("current", k === at); });
  slider.value = at;
  label.textContent = views[at] ? views[at].dataset.title : "";
}

links.forEach((link, at) => {
  link.querySelector("img").src = views[at].querySelector("img").src;
});
// A view can be named in the address, and is there after a click.
function showAddressed() {
  show(Math.max(0, views.findIndex((view) => `#${view.id}` === decodeURIComponent(location.hash))));
}

links.forEach((link, at) => link.addEventListener("click", (event) => {
  event.preventDefault();
  history.replaceState(null, "", `#${views[at].id}`);
  show(at);
}));
addEventListener("hashchange", showAddressed);
slider.addEventListener("input", () => show(Number(slider.value)));
if (typeof lampyrisTimings === "object") {
  views.forEach((view) => {
    const seconds = lampyrisTimings[view.id];
    if (seconds !== undefined) {
      view.querySelector(".seconds").textContent = `${seconds.toFixed(2)} s`;
    }
  });
}
showAddressed();
