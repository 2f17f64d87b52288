"use strict";
// What a frame of a width shows; written as JSON once all of them are looked at.
const frames = widths.map(width => {
  const frame = document.body.appendChild(document.createElement("iframe"));
  frame.style.cssText = `width:${width}px;height:900px;border:0`;
  frame.srcdoc = page;
  return frame;
});

// Pictures are drawn anew after what asked for it has ended.
const drawnAnew = () => new Promise(done => setTimeout(done, 100));

async function look(frame, width) {
  const view = frame.contentWindow, page = frame.contentDocument;
  const name = element => `${element.tagName}.${element.className} ${Math.round(element.getBoundingClientRect().right)}`;
  // What lies in something that scrolls is not cut.
  const scrolls = element => element.closest(".table, pre, .uplot, .skip");
  const cut = [...page.querySelectorAll("main *")].filter(element => {
    const box = element.getBoundingClientRect();
    return box.width && !scrolls(element) && (box.right > width + 1 || box.left < -1);
  });
  const inside = [...page.querySelectorAll(".table, pre, .uplot")].filter(element => {
    const box = element.getBoundingClientRect();
    return box.width && box.right > width + 1;
  });
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
  const pictureBottom = page.querySelector("#picture .uplot").getBoundingClientRect().bottom;

  const recordings = page.querySelectorAll("details.recording");
  const first = recordings[0], place = first.querySelector(".curves > div"), group = of(first);
  const whole = spans(group)[0];
  press(place, "+");
  await drawnAnew();
  const linkedByKey = group.length >= 3 && alike(group) && spans(group)[0] !== whole;
  press(place, "0");
  await drawnAnew();
  const wholeAgain = alike(group) && spans(group)[0] === whole;
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
  return { width, pageWidth: page.documentElement.scrollWidth, errors: view.errors, cut: [...cut, ...inside].map(name),
    pictures: charts().length, empty: canvases.filter(canvas => canvas.width && !drawn(canvas)).length, pictureBottom,
    linkedByKey, wholeAgain, linkedByButton, hiddenByKey };
}

setTimeout(async () => {
  const failed = index => error => ({ width: widths[index], errors: [String(error), error.stack] });
  const seen = await Promise.all(frames.map((frame, index) => look(frame, widths[index]).catch(failed(index))));
  document.getElementById("seen").textContent = JSON.stringify(seen);
}, 10000);
