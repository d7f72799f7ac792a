"use strict";
// Draws the figures of the report. Signals are kept whole; what is drawn is thinned to the width of the screen, and
// again after each zoom, so that every sample can be reached. Figures over time zoom together.
(function () {
  const POINTS = 3000;
  const figures = JSON.parse(document.getElementById("figures").textContent);
  const timeFigures = [];
  let busy = false;

  function unpack(packed) {
    if (Array.isArray(packed)) return packed;
    if (packed.count !== undefined) {
      return Float64Array.from({ length: packed.count }, (_, i) => packed.start + i * packed.step);
    }
    const text = atob(packed.float32);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return Float64Array.from(new Float32Array(bytes.buffer), (value) => value + packed.offset);
  }

  function firstAtLeast(x, value) {
    let low = 0, high = x.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (x[middle] < value) low = middle + 1; else high = middle;
    }
    return low;
  }

  // The part of a signal between two times, as at most POINTS samples: smallest and largest of each stretch.
  function visible(signal, from, to) {
    const first = Math.max(firstAtLeast(signal.x, from) - 1, 0);
    const last = Math.min(firstAtLeast(signal.x, to) + 1, signal.x.length);
    const count = last - first;
    if (count <= POINTS) {
      return { x: Array.from(signal.x.slice(first, last)), y: Array.from(signal.y.slice(first, last)) };
    }
    const x = [], y = [], stretches = POINTS / 2;
    for (let s = 0; s < stretches; s++) {
      const a = first + Math.floor((s * count) / stretches), b = first + Math.floor(((s + 1) * count) / stretches);
      let low = a, high = a;
      for (let i = a + 1; i < b; i++) {
        if (signal.y[i] < signal.y[low]) low = i;
        if (signal.y[i] > signal.y[high]) high = i;
      }
      for (const i of low < high ? [low, high] : [high, low]) { x.push(signal.x[i]); y.push(signal.y[i]); }
    }
    return { x, y };
  }

  const WIDE = 640;
  const PAPER = 1030;  // A4 between its margins at the zoom of the style sheet: 186 mm, 96 dots an inch, 0.68
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const config = { responsive: true, displaylogo: false, toImageButtonOptions: { format: "svg" } };
  // Figures over time keep one right-hand edge: that of the longest name beside a trace.
  const LETTER = 7.5, longest = Math.max(0, ...figures.flatMap((figure) => figure.labels.map((one) => one.text.length)));
  const BESIDE = Math.max(120, Math.ceil(LETTER * longest) + 16);
  let printing = false;

  function colours() {
    return dark.matches && !printing
      ? { page: "#12181e", ink: "#dde5ec", grid: "#2a3641", zero: "#4a5a68", line: "#62737f" }
      : { page: "#ffffff", ink: "#1b2733", grid: "#e6ecf1", zero: "#c5d0d9", line: "#9fb0bf" };
  }

  // Colours that are dim on the dark page, and what is drawn there for them; report.css does the same for legends.
  const LIGHTER = { "#0072b2": "#4ba3e3", "#009e73": "#22b98a", "#d55e00": "#ff8a45", "#8c564b": "#b9837a" };
  const shade = (value) => value && dark.matches && !printing
    ? JSON.parse(JSON.stringify(value), (key, one) => LIGHTER[one] || one) : value;

  // In a narrow figure names stand above it, where the buttons would cover them.
  const buttons = (div) => Object.assign({}, config, div.clientWidth < WIDE ? { displayModeBar: false } : {});

  // What of a layout depends on the light and on the width: in a wide figure names stand beside the traces.
  function dress(div, figure) {
    const c = colours(), beside = figure.labels.length > 0 && (printing || div.clientWidth >= WIDE);
    const layout = Object.assign({}, shade(figure.layout), printing ? { width: PAPER } : {}, {
      autosize: !printing, height: figure.height, hovermode: "x", dragmode: "zoom",
      margin: beside ? { l: 70, r: BESIDE, t: 34, b: 45 } : { l: 50, r: 18, t: 26, b: 45 },
      paper_bgcolor: c.page, plot_bgcolor: c.page, font: { size: beside ? 12 : 11, color: c.ink },
      showlegend: !beside, legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 },
      annotations: beside ? shade(figure.labels).map((label) => ({
        text: label.text, font: { color: label.color, size: 13 }, showarrow: false,
        xref: "paper", x: 1.005, xanchor: "left", yref: "paper", y: label.y, yanchor: "middle",
      })) : [],
    });
    for (const name of Object.keys(layout)) {
      if (/^[xy]axis/.test(name)) {
        layout[name] = Object.assign({ gridcolor: c.grid, zerolinecolor: c.zero, linecolor: c.line, ticks: "outside",
          automargin: true }, layout[name]);
      }
    }
    return layout;
  }

  function draw(div, figure) {
    const layout = dress(div, figure);
    const signals = [], traces = [];
    figure.traces.forEach((trace, index) => {
      const drawn = Object.assign({ type: "scatter" }, trace, { line: shade(trace.line) });
      if (figure.traces.findIndex((other) => other.name === trace.name) < index) drawn.showlegend = false;
      if (Array.isArray(trace.x)) { traces.push(drawn); return; }
      const signal = { index, x: unpack(trace.x), y: unpack(trace.y) };
      signals.push(signal);
      traces.push(Object.assign(drawn, visible(signal, -Infinity, Infinity)));
    });
    const entry = { div, signals };
    return Plotly.newPlot(div, traces, layout, buttons(div)).then(() => {
      if (!figure.time) return;
      timeFigures.push(entry);
      div.on("plotly_relayout", (event) => zoomed(event));
    });
  }

  function zoomed(event) {
    if (busy) return;
    const from = event["xaxis.range[0]"], to = event["xaxis.range[1]"];
    if (from !== undefined && to !== undefined) zoomAll(Number(from), Number(to));
    else if (event["xaxis.autorange"]) zoomAll(-Infinity, Infinity);
  }

  function zoomAll(from, to) {
    busy = true;
    const range = isFinite(from) ? { "xaxis.range": [from, to] } : { "xaxis.autorange": true };
    const done = timeFigures.map(({ div, signals }) => {
      const parts = signals.map((signal) => visible(signal, from, to));
      return Plotly.update(div, { x: parts.map((p) => p.x), y: parts.map((p) => p.y) }, range,
        signals.map((signal) => signal.index));
    });
    Promise.all(done).finally(() => { busy = false; });
  }

  const drawn = figures.map((figure, index) => draw(document.getElementById("figure-" + index), figure));
  Promise.all(drawn).then(() => { document.body.dataset.ready = "true"; });

  // Light, width or paper have changed: everything is dressed again, and what was zoomed into stays.
  const dressAll = () => figures.forEach((figure, index) => {
    const div = document.getElementById("figure-" + index);
    if (!div.layout) return;
    const layout = dress(div, figure);
    for (const name of Object.keys(layout)) {
      const now = div.layout[name];
      if (/^[xy]axis/.test(name) && now && now.range) {
        layout[name] = Object.assign({}, layout[name], { range: now.range, autorange: now.autorange });
      }
    }
    const data = div.data.map((trace, n) => Object.assign({}, trace, { line: shade(figure.traces[n].line) }));
    Plotly.react(div, data, layout, buttons(div)).then(() => { if (!printing) Plotly.Plots.resize(div); });
  });
  dark.addEventListener("change", dressAll);
  let settling = 0;
  window.addEventListener("resize", () => { clearTimeout(settling); settling = setTimeout(dressAll, 150); });
  const resizeAll = () => document.querySelectorAll(".figure").forEach((div) => Plotly.Plots.resize(div));
  document.querySelectorAll("details").forEach((element) => element.addEventListener("toggle", resizeAll));
  window.addEventListener("beforeprint", () => {
    document.querySelectorAll("details").forEach((element) => { element.open = true; });
    printing = true;
    dressAll();
  });
  window.addEventListener("afterprint", () => { printing = false; dressAll(); });
})();
