"use strict";
// Moves the drawing of the lift: ship and boom tip, drum, rope and load over the time of the run.
(function () {
  const motion = JSON.parse(document.getElementById("motion").textContent);
  const part = (name) => document.getElementById("lift-" + name);
  const columns = {};
  for (const [name, packed] of Object.entries(motion.columns)) {
    const bytes = Uint8Array.from(atob(packed.int16), (one) => one.charCodeAt(0));
    columns[name] = Float32Array.from(new Int16Array(bytes.buffer), (one) => one * packed.unit);
  }
  const last = motion.count - 1, slider = part("time"), play = part("play");
  slider.max = last;
  let at = Math.min(Math.max((motion.first - motion.start) / motion.step, 0), last), playing = false, before = 0;

  // The value of a column between two samples, 0 where it was not recorded.
  function value(name) {
    const values = columns[name];
    if (!values) return 0;
    const low = Math.floor(at), high = Math.min(low + 1, last);
    return values[low] + (values[high] - values[low]) * (at - low);
  }

  function mode(time) {
    let found = "";
    for (const [start, name] of motion.modes) { if (start <= time) found = name; }
    return found.replaceAll("_", " ");
  }

  const cm = (metres) => (100 * metres).toFixed(1) + " cm";

  function show() {
    const time = motion.start + at * motion.step, k = motion.scale;
    const tip = value("tip"), load = value("load"), locked = value("locked");
    part("ship").setAttribute("transform", `translate(0 ${-k * tip})`);
    part("drum").setAttribute("transform", `translate(140 56) rotate(${(value("payout") / motion.radius) * 180 / Math.PI})`);
    part("load").setAttribute("transform", `translate(0 ${-k * load})`);
    if (part("locked")) part("locked").setAttribute("transform", `translate(0 ${-k * locked})`);
    part("rope").setAttribute("y1", 16 - k * tip);
    part("rope").setAttribute("y2", 172 - k * load);
    slider.value = Math.round(at);
    const words = [time.toFixed(0) + " s", mode(time), "boom tip " + cm(tip), "load " + cm(load)];
    if (columns.locked) words.push("with the winch locked " + cm(locked));
    part("now").textContent = words.filter(Boolean).join(", ");
  }

  function step(now) {
    if (!playing) return;
    at += ((now - before) / 1000) * Number(part("speed").value) / motion.step;
    before = now;
    if (at >= last) { at = last; toggle(); }
    show();
    requestAnimationFrame(step);
  }

  function toggle() {
    playing = !playing;
    if (playing && at >= last) at = 0;
    play.textContent = playing ? "\u2016" : "\u25B6";
    play.setAttribute("aria-label", playing ? "Pause" : "Play");
    if (playing) { before = performance.now(); requestAnimationFrame(step); }
  }

  // A ruler of a round length that fits beside the load.
  const length = [2, 1, 0.5, 0.2, 0.1].find((metres) => metres * motion.scale <= 60) || 0.1;
  part("ruler").setAttribute("d", `M24 ${206 - length * motion.scale} h8 m-4 0 V206 m-4 0 h8`);
  part("ruler-text").textContent = length >= 1 ? length + " m" : 100 * length + " cm";
  play.addEventListener("click", toggle);
  slider.addEventListener("input", () => { at = Number(slider.value); show(); });
  show();
})();
