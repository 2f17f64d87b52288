"use strict";
(() => {
  const plot = JSON.parse(document.getElementById("plot").textContent);
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const decoded = samples => samples && samples.at.map(at => at === null ? null : at * samples.step);
  const digits = value => value == null ? "–" : Number(value.toPrecision(5)).toString();
  const less = (values, by, factor) => values.map((v, i) => v === null || by[i] === null ? null : v - by[i] / factor);
  const prefixes = { n: 1e9, "\u00b5": 1e6, m: 1e3 };
  const residualFactor = plot.residual_unit === plot.position_unit ? 1 : prefixes[plot.residual_unit[0]];
  const FONT = "12px system-ui, sans-serif";
  // What is on the page: each knows how to draw itself again where colours or widths change.
  const drawn = [];

  const axis = (label, more) => Object.assign({ label, font: FONT, labelFont: FONT, labelSize: 20, size: 32, stroke: colour("quiet"),
    grid: { stroke: colour("line"), width: 1 }, ticks: { stroke: colour("line"), width: 1, size: 5 } }, more);
  const valueAxis = (label, more) => axis(label, Object.assign({ size: 64 }, more));
  // Curves above each other share the time axis of the lowest, and leave room for the second value axis it may have.
  const bare = () => axis(undefined, { labelSize: 0, size: 30 });
  const line = (label, name, more) => Object.assign({ label, stroke: colour(name), width: 1.25, points: { show: false },
    value: (_, value) => digits(value) }, more);
  const time = { label: "time (s)", value: (_, value) => value == null ? "–" : value.toFixed(4) };

  // Draws into a place, and again on demand with the zoom kept.
  function draw(place, height, data, options, label) {
    place.setAttribute("role", "img");
    place.setAttribute("aria-label", label);
    const entry = { place, chart: null, again(width) {
      const zoom = entry.chart && [entry.chart.scales.x.min, entry.chart.scales.x.max];
      if (entry.chart) entry.chart.destroy();
      entry.chart = new uPlot({ width: width || place.clientWidth || 640, height, ...options() }, data, place);
      if (zoom) entry.chart.setScale("x", { min: zoom[0], max: zoom[1] });
    } };
    entry.again();
    drawn.push(entry);
    new ResizeObserver(() => {
      const width = place.clientWidth;
      if (width && width !== entry.chart.width) entry.chart.setSize({ width, height });
    }).observe(place);
    return entry;
  }

  // Shades the spans of time that the answer names.
  const shaded = spans => chart => {
    const { ctx, bbox } = chart;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.fillStyle = colour("span");
    for (const [start, end] of spans) {
      const from = chart.valToPos(start, "x", true), to = chart.valToPos(end, "x", true);
      ctx.fillRect(from, bbox.top, Math.max(to - from, 2), bbox.height);
    }
    ctx.restore();
  };

  function curves(index, place) {
    const r = plot.recordings[index];
    const t = decoded(r.t_s), recorded = decoded(r.recorded), before = decoded(r.before), after = decoded(r.after);
    const field = decoded(r.field_kv_mm);
    const common = secondAxis => ({ scales: { x: { time: false } }, padding: [8, secondAxis || !field ? 8 : 92, 0, 0], hooks: { drawClear: [shaded(r.spans)] },
      cursor: { y: false, sync: { key: "recording" + index }, drag: { x: true, y: false } } });
    const add = (height, data, series, axes, label, secondAxis) => {
      const div = place.appendChild(document.createElement("div"));
      draw(div, height, data, () => ({ ...common(secondAxis), series: series(), axes: axes() }), label + " of " + r.name +
        " over time; the tables on this page hold the figures");
    };
    const held = { paths: uPlot.paths.stepped({ align: 1 }) };
    add(240, [t, recorded, less(recorded, before, residualFactor), ...(after ? [less(recorded, after, residualFactor)] : [])],
      () => [time, line("recorded", "recorded", { width: 3 }), line("nominal", "nominal"),
        ...(after ? [line("improved", "improved")] : [])],
      () => [bare(), valueAxis(`position (${plot.position_unit})`)], "Position");
    add(240, [t, before, ...(after ? [after] : [])],
      () => [time, line("recorded − nominal", "nominal"), ...(after ? [line("recorded − improved", "improved")] : [])],
      () => [bare(), valueAxis(`residual (${plot.residual_unit})`)], "Residual before and after");
    // The field may chatter: the torque is drawn over it.
    add(180, [t, ...(field ? [field] : []), decoded(r.effort)],
      () => [time, ...(field ? [line("field command", "extra", { ...held, scale: "field", width: 0.75 })] : []),
        line(`${plot.effort_name} command`, "ink", { ...held, scale: "effort" })],
      () => [axis("time (s)"), valueAxis(`${plot.effort_name} (${plot.effort_unit})`, { scale: "effort" }),
        ...(field ? [valueAxis("field (kV/mm)", { scale: "field", side: 1, grid: { show: false } })] : [])], "Commands", Boolean(field));
  }

  function map(place) {
    const m = plot.maps[Number(place.dataset.index)];
    const edge = (band, sign) => band.mean.map((mean, i) => band.half[i] === null ? null : mean + sign * band.half[i]);
    const triple = band => [edge(band, 1), edge(band, -1), band.mean];
    const spread = (band, label, name) => {
      const bound = { class: "edge", stroke: "transparent", points: { show: false }, label: "" };
      return [bound, bound, line(label, name, { width: 2, points: { show: true, size: 5, fill: colour(name) },
        value: (_, value, __, i) => i == null ? "–" : digits(value) +
          (band.half[i] === null ? "" : " ± " + Number(band.half[i].toPrecision(2))) })];
    };
    const options = () => ({
      scales: { x: { time: false } }, cursor: { y: false, drag: { x: true, y: false } },
      series: [{ label: m.x_label, value: (_, value) => digits(value) }, ...spread(m.before, "nominal", "nominal"),
        ...(m.after ? spread(m.after, "improved", "improved") : [])],
      axes: [axis(m.x_label), valueAxis(m.y_label)],
      bands: [{ series: [1, 2], fill: colour("nominal") + "30" },
        ...(m.after ? [{ series: [4, 5], fill: colour("improved") + "30" }] : [])],
    });
    draw(place, 260, [m.x, ...triple(m.before), ...(m.after ? triple(m.after) : [])], options,
      `${m.title}: ${m.y_label} over ${m.x_label}, with 95 % bands; figures below`);
  }

  for (const details of document.querySelectorAll("details.recording")) {
    const place = details.querySelector(".curves");
    const once = () => { if (details.open && !place.children.length) curves(Number(details.dataset.index), place); };
    details.addEventListener("toggle", once);
    once();
  }
  document.querySelectorAll(".map").forEach(map);

  for (const button of document.querySelectorAll("button.show")) {
    button.addEventListener("click", () => {
      const { index, start, end } = button.dataset;
      const details = document.querySelector(`details.recording[data-index="${index}"]`);
      const margin = 0.5 * (end - start) + 0.05;
      details.open = true;
      const place = details.querySelector(".curves");
      if (!place.children.length) curves(Number(index), place);
      drawn.filter(entry => place.contains(entry.place))
        .forEach(entry => entry.chart.setScale("x", { min: start - margin, max: Number(end) + margin }));
      details.scrollIntoView({ block: "start" });
    });
  }

  const redraw = width => drawn.forEach(entry => entry.again(width && Math.min(width, entry.place.clientWidth)));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redraw());
  addEventListener("beforeprint", () => { document.documentElement.dataset.print = ""; redraw(660); });
  addEventListener("afterprint", () => { delete document.documentElement.dataset.print; redraw(); });
})();
