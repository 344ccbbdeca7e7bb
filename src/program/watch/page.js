"use strict";
// Asks for news, shows them, and asks again.

const main = document.querySelector("main");
const [status, message, text] = ["status", "message", "text"].map((id) => document.getElementById(id));

/** One figure a picture, by its place; an image is replaced once its successor is there. */
function show(picture, figure) {
  const image = figure.querySelector("img");
  image.width = picture.width;
  image.height = picture.height;
  image.alt = picture.name;
  figure.className = picture.is_from_this_run ? "" : "old";
  figure.dataset.shrink = picture.shrink;
  const size = picture.shrink > 1 ? `1/${picture.shrink} of ` : "";
  figure.querySelector("figcaption").textContent =
    `${picture.name} · ${size}${picture.width} × ${picture.height}`;
  if (image.dataset.version !== String(picture.version)) {
    image.dataset.version = picture.version;
    image.src = `/picture/${picture.version}`;
  }
}

function update(news) {
  while (main.children.length > news.pictures.length) main.lastChild.remove();
  while (main.children.length < news.pictures.length) {
    const figure = document.createElement("figure");
    figure.append(document.createElement("img"), document.createElement("figcaption"));
    main.append(figure);
  }
  news.pictures.forEach((picture, at) => show(picture, main.children[at]));
  status.textContent = `run ${news.run}: ${news.status}`;
  message.hidden = news.message === "";
  message.textContent = news.message;
  text.textContent = news.text;
}

async function follow() {
  let version = 0;
  for (;;) {
    try {
      const news = await (await fetch(`/news/${version}`)).json();
      version = news.version;
      update(news);
    } catch {
      status.textContent = "lampyris does not answer: it has ended, or is busy";
      version = 0;
      await new Promise((done) => setTimeout(done, 1000));
    }
  }
}

follow();
