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

  // All pictures of one group show the same stretch.
  const show = (entry, min, max) => drawn.filter(other => other === entry || (entry.group && other.group === entry.group))
    .forEach(other => other.chart.setScale("x", { min, max }));

  // A picture under the keyboard: arrows move, + and − zoom, 0 shows the whole.
  function keys(entry, x) {
    const ends = [x[0], x[x.length - 1]];
    entry.place.addEventListener("keydown", event => {
      if (event.target !== entry.place || event.ctrlKey || event.metaKey || event.altKey) return;
      const { min, max } = entry.chart.scales.x, span = max - min, middle = (min + max) / 2;
      const to = { ArrowLeft: [min - span / 5, max - span / 5], ArrowRight: [min + span / 5, max + span / 5],
        "+": [middle - span / 4, middle + span / 4], "=": [middle - span / 4, middle + span / 4],
        "-": [Math.max(ends[0], middle - span), Math.min(ends[1], middle + span)], 0: ends, Home: ends }[event.key];
      if (!to || to[1] <= ends[0] || to[0] >= ends[1] || to[1] <= to[0]) return;
      event.preventDefault();
      show(entry, to[0], to[1]);
    });
  }

  // Names in the legend hide their curves: by keyboard, too.
  function legend(place) {
    for (const name of place.querySelectorAll(".u-legend .u-series:not(.edge):not(:first-child) th")) {
      name.tabIndex = 0;
      name.setAttribute("role", "button");
      name.setAttribute("aria-label", "Show or hide " + name.textContent);
      name.addEventListener("keydown", event => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        name.click();
      });
    }
  }

  // Draws into a place, and again on demand with the zoom kept.
  function draw(place, height, data, options, label, group) {
    place.setAttribute("role", "group");
    place.setAttribute("aria-roledescription", "chart");
    place.setAttribute("aria-label", label);
    place.tabIndex = 0;
    const entry = { place, group, chart: null, again(width) {
      const zoom = entry.chart && [entry.chart.scales.x.min, entry.chart.scales.x.max];
      if (entry.chart) entry.chart.destroy();
      entry.chart = new uPlot({ width: width || place.clientWidth || 640, height, ...options() }, data, place);
      if (zoom) entry.chart.setScale("x", { min: zoom[0], max: zoom[1] });
      legend(place);
    } };
    entry.again();
    drawn.push(entry);
    keys(entry, data[0]);
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

  // Shades where residuals are of which only noise is left.
  const noisy = half => chart => {
    const { ctx, bbox } = chart;
    const [top, bottom] = [half, -half].map(value => chart.valToPos(value, "y", true));
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.fillStyle = colour("noise");
    ctx.fillRect(bbox.left, top, bbox.width, Math.max(bottom - top, 1));
    ctx.restore();
  };

  const linked = index => ({ y: false, sync: { key: "recording" + index }, drag: { x: true, y: false } });
  // Noise alone is always seen beside what is left.
  const residualScale = half => ({ range: (_, min, max) => {
    const [low, high] = [Math.min(min ?? 0, -half), Math.max(max ?? 0, half)], margin = 0.05 * (high - low) || 1;
    return [low - margin, high + margin];
  } });

  function picture(place) {
    const index = plot.first, r = plot.recordings[index];
    const before = decoded(r.before), after = decoded(r.after);
    draw(place, 260, [decoded(r.t_s), before, ...(after ? [after] : [])], () => ({
      scales: { x: { time: false }, y: residualScale(r.noise) }, padding: [8, 8, 0, 0], cursor: linked(index),
      hooks: { drawClear: [shaded(r.spans), noisy(r.noise)] },
      series: [time, line("recorded − nominal", "nominal"), ...(after ? [line("recorded − improved", "improved")] : [])],
      axes: [axis("time (s)"), valueAxis(`residual (${plot.residual_unit})`)],
    }), `Residual of both models along ${r.name}; the figures are under How well it fits`, "recording" + index);
  }

  function curves(index, place) {
    const r = plot.recordings[index];
    const t = decoded(r.t_s), recorded = decoded(r.recorded), before = decoded(r.before), after = decoded(r.after);
    const field = decoded(r.field_kv_mm);
    const common = (secondAxis, noise) => ({ scales: { x: { time: false }, ...(noise ? { y: residualScale(noise) } : {}) },
      padding: [8, secondAxis || !field ? 8 : 92, 0, 0], cursor: linked(index),
      hooks: { drawClear: noise ? [shaded(r.spans), noisy(noise)] : [shaded(r.spans)] } });
    const add = (height, data, series, axes, label, { secondAxis, noise } = {}) => {
      const div = place.appendChild(document.createElement("div"));
      draw(div, height, data, () => ({ ...common(secondAxis, noise), series: series(), axes: axes() }), label + " of " + r.name +
        " over time; the tables on this page hold the figures", "recording" + index);
    };
    const held = { paths: uPlot.paths.stepped({ align: 1 }) };
    add(240, [t, recorded, less(recorded, before, residualFactor), ...(after ? [less(recorded, after, residualFactor)] : [])],
      () => [time, line("recorded", "recorded", { width: 3 }), line("nominal", "nominal"),
        ...(after ? [line("improved", "improved", { dash: [8, 5] })] : [])],
      () => [bare(), valueAxis(`position (${plot.position_unit})`)], "Position");
    const residual = (values, label, name) => add(170, [t, values], () => [time, line("recorded − " + label, name)],
      () => [bare(), valueAxis(`residual (${plot.residual_unit})`)], `Residual of the ${label} model`, { noise: r.noise });
    residual(before, "nominal", "nominal");
    if (after) residual(after, "improved", "improved");
    // The field may chatter: the torque is drawn over it.
    add(180, [t, ...(field ? [field] : []), decoded(r.effort)],
      () => [time, ...(field ? [line("field command", "extra", { ...held, scale: "field", width: 0.75 })] : []),
        line(`${plot.effort_name} command`, "ink", { ...held, scale: "effort" })],
      () => [axis("time (s)"), valueAxis(`${plot.effort_name} (${plot.effort_unit})`, { scale: "effort" }),
        ...(field ? [valueAxis("field (kV/mm)", { scale: "field", side: 1, grid: { show: false } })] : [])], "Commands", { secondAxis: Boolean(field) });
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

  function left(place) {
    const m = plot.left[Number(place.dataset.index)];
    const bound = { class: "edge", stroke: "transparent", points: { show: false }, label: "" };
    const logarithmic = { distr: 3 };
    draw(place, 240, [m.x, m.low, m.high, m.nominal, ...(m.improved ? [m.improved] : [])], () => ({
      scales: { x: { time: false, ...(m.log ? logarithmic : {}) }, ...(m.log ? { y: logarithmic } : {}) },
      cursor: { y: false, drag: { x: true, y: false } },
      series: [{ label: m.x_label, value: (_, value) => digits(value) }, bound, bound, line("nominal", "nominal", { dash: [8, 5] }),
        ...(m.improved ? [line("improved", "improved", { width: 1.75 })] : [])],
      axes: [axis(m.x_label), valueAxis(m.y_label)],
      bands: [{ series: [2, 1], fill: colour("noise") }],
    }), `${m.title} of what is left, with the band of noise alone; the figures are in the table above`);
  }

  document.querySelectorAll(".picture").forEach(picture);
  for (const details of document.querySelectorAll("details.recording")) {
    const place = details.querySelector(".curves");
    const once = () => { if (details.open && !place.children.length) curves(Number(details.dataset.index), place); };
    details.addEventListener("toggle", once);
    once();
  }
  document.querySelectorAll(".map").forEach(map);
  document.querySelectorAll(".left").forEach(left);

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
