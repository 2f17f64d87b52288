"use strict";
// What frames of each width show of each page; written as JSON once all of them are looked at.
const frames = pages.flatMap(({ name, text }) => widths.map(width => {
  const frame = document.body.appendChild(document.createElement("iframe"));
  frame.style.cssText = `width:${width}px;height:900px;border:0`;
  frame.srcdoc = text;
  return { frame, name, width };
}));

// Pictures are drawn anew after what asked for it has ended.
const drawnAnew = () => new Promise(done => setTimeout(done, 100));

// What is true of every page: nothing is cut, and the picture is seen at once.
function whole(view, page, width) {
  const name = element => `${element.tagName}.${element.className} ${Math.round(element.getBoundingClientRect().right)}`;
  // What lies in something that scrolls is not cut.
  const scrolls = element => element.closest(".table, pre, .uplot, .drawing, .skip");
  const cut = [...page.querySelectorAll("main *")].filter(element => {
    const box = element.getBoundingClientRect();
    return box.width && !scrolls(element) && (box.right > width + 1 || box.left < -1);
  });
  const inside = [...page.querySelectorAll(".table, pre, .uplot, .drawing")].filter(element => {
    const box = element.getBoundingClientRect();
    return box.width && box.right > width + 1;
  });
  // A word that the script of a drawing wrote beyond it cannot be scrolled to.
  const drawings = [...page.querySelectorAll(".drawing svg")].filter(svg => svg.getBoundingClientRect().width);
  const beyond = drawings.flatMap(svg => [...svg.querySelectorAll("text")].filter(word =>
    word.getBoundingClientRect().right > svg.getBoundingClientRect().right + 1));
  // A page of tables has none.
  const pictureBottom = page.querySelector("#picture .uplot, #picture svg")?.getBoundingClientRect().bottom ?? null;
  return { pageWidth: page.documentElement.scrollWidth, errors: view.errors, cut: [...cut, ...inside].map(name),
    beyond: beyond.map(word => word.textContent.trim()), drawings: drawings.length, pictureBottom };
}

async function look(frame, width) {
  const view = frame.contentWindow, page = frame.contentDocument, seen = whole(view, page, width);
  if (!view.made) return seen;
  const canvases = [...page.querySelectorAll(".uplot canvas")];
  const drawn = canvas => {
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let count = 0;
    for (let i = 3; i < pixels.length; i += 4) count += pixels[i] > 0;
    return count > 500;
  };
  const charts = () => view.made.filter(chart => chart.root.isConnected);
  const of = place => charts().filter(chart => place.contains(chart.root));
  const spans = list => list.map(chart => [chart.scales.x.min, chart.scales.x.max].map(end => end.toPrecision(9)).join());
  const alike = list => new Set(spans(list)).size === 1;
  const press = (element, key) => element.dispatchEvent(new view.KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));

  const recordings = page.querySelectorAll("details.recording");
  const first = recordings[0], place = first.querySelector(".curves > div"), group = of(first);
  const all = spans(group)[0];
  press(place, "+");
  await drawnAnew();
  const linkedByKey = group.length >= 3 && alike(group) && spans(group)[0] !== all;
  press(place, "0");
  await drawnAnew();
  const wholeAgain = alike(group) && spans(group)[0] === all;
  const button = page.querySelector("button.show");
  let linkedByButton = true;
  if (button) {
    const shown = of(recordings[button.dataset.index]);
    const before = spans(shown)[0];
    button.click();
    await drawnAnew();
    linkedByButton = alike(shown) && spans(shown)[0] !== before;
  }
  const label = place.querySelector(".u-legend [role=button]");
  const before = label.closest(".u-series").classList.contains("u-off");
  press(label, "Enter");
  const hiddenByKey = label.closest(".u-series").classList.contains("u-off") !== before;
  return { ...seen, pictures: charts().length, empty: canvases.filter(canvas => canvas.width && !drawn(canvas)).length,
    linkedByKey, wholeAgain, linkedByButton, hiddenByKey };
}

setTimeout(async () => {
  const one = ({ frame, name, width }) => look(frame, width)
    .catch(error => ({ errors: [String(error), error.stack] })).then(seen => ({ name, width, ...seen }));
  document.getElementById("seen").textContent = JSON.stringify(await Promise.all(frames.map(one)));
  // What the browser prints is this page, without those it looked at.
  document.querySelectorAll("iframe, script").forEach(element => element.remove());
}, 10000);
