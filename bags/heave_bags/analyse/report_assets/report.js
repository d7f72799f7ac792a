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

  const common = {
    autosize: true, margin: { l: 70, r: 20, t: 10, b: 45 }, hovermode: "x", dragmode: "zoom",
    paper_bgcolor: "#fff", plot_bgcolor: "#fff", font: { size: 12, color: "#1b2733" },
    legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 },
  };
  const axis = { gridcolor: "#e6ecf1", zerolinecolor: "#c5d0d9", linecolor: "#9fb0bf", ticks: "outside", automargin: true };
  const config = { responsive: true, displaylogo: false, toImageButtonOptions: { format: "svg" } };

  function draw(div, figure) {
    const layout = Object.assign({}, common, figure.layout, { height: figure.height });
    for (const name of Object.keys(layout)) {
      if (/^[xy]axis/.test(name)) layout[name] = Object.assign({}, axis, layout[name]);
    }
    const signals = [], traces = [];
    figure.traces.forEach((trace, index) => {
      const drawn = Object.assign({ type: "scatter" }, trace);
      if (Array.isArray(trace.x)) { traces.push(drawn); return; }
      const signal = { index, x: unpack(trace.x), y: unpack(trace.y) };
      signals.push(signal);
      traces.push(Object.assign(drawn, visible(signal, -Infinity, Infinity)));
    });
    const entry = { div, signals };
    return Plotly.newPlot(div, traces, layout, config).then(() => {
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

  const resizeAll = () => document.querySelectorAll(".figure").forEach((div) => Plotly.Plots.resize(div));
  document.querySelectorAll("details").forEach((element) => element.addEventListener("toggle", resizeAll));
  window.addEventListener("beforeprint", () => {
    document.querySelectorAll("details").forEach((element) => { element.open = true; });
    resizeAll();
  });
})();
