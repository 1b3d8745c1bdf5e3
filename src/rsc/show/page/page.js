"use strict";
// The page without script is complete; this lays plotly's pictures over the drawn ones and moves one cursor through all of them.
(async () => {
  if (!window.DecompressionStream) return;
  // base 85, five letters for four bytes; what is missing of the last five was no byte
  const digits = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;,=>?@^_`{|}~";
  const unlettered = (text) => {
    const missing = (5 - text.length % 5) % 5, letters = text + "~".repeat(missing);
    const out = new DataView(new ArrayBuffer(letters.length / 5 * 4));
    for (let k = 0; k < letters.length; k += 5) {
      out.setUint32(k / 5 * 4, [0, 1, 2, 3, 4].reduce((sum, i) => 85 * sum + digits.indexOf(letters[k + i]), 0));
    }
    return out.buffer.slice(0, out.byteLength - missing);
  };
  const unpacked = (name) => {
    const stored = new Blob([unlettered(document.getElementById(name).textContent)]);
    return new Response(stored.stream().pipeThrough(new DecompressionStream("gzip"))).text();
  };
  const report = JSON.parse(await unpacked("report"));
  const script = document.createElement("script");
  script.textContent = await unpacked("library");
  document.head.append(script);
  if (!window.Plotly) return;

  const style = () => {
    const value = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    return {ink: value("--ink"), soft: value("--soft"), rim: value("--rim"), paper: value("--paper")};
  };
  const shades = () => [[0, style().paper], [1, style().ink]];
  const narrow = () => window.innerWidth < 640;
  const layoutOf = (layout) => {
    const {ink, rim, soft} = style();
    const axis = (own) => ({gridcolor: rim, linecolor: rim, zerolinecolor: rim, automargin: true, ...own, title: {text: own.title}});
    return {
      height: layout.height + (narrow() ? 0 : 40), margin: {l: 66, r: 36, t: 12, b: 46}, hovermode: "closest",
      modebar: {orientation: "v", bgcolor: "rgba(0,0,0,0)", color: soft, activecolor: ink},
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: {color: ink, size: 12, family: "system-ui, sans-serif"},
      showlegend: !layout.equal && !narrow(), legend: {orientation: "h", x: 0, y: 1, yanchor: "bottom", font: {size: 11}},
      xaxis: axis(layout.xaxis), yaxis: axis(layout.equal ? {...layout.yaxis, scaleanchor: "x"} : layout.yaxis), separators: separators(),
    };
  };
  // decimal sign and thousands as the reader's browser writes them
  const separators = () => {
    const parts = new Intl.NumberFormat().formatToParts(12345.6);
    const part = (type, other) => (parts.find((each) => each.type === type) || {value: other}).value;
    return part("decimal", ".") + part("group", " ");
  };
  const options = {responsive: true, displaylogo: false, scrollZoom: false, modeBarButtons: [["zoom2d", "pan2d", "resetScale2d", "toImage"]]};
  const drawn = {};
  const draw = async (name, picture) => {
    const place = document.getElementById(name);
    const data = picture.data.map((trace) => (trace.type === "heatmap"
      ? {...trace, colorscale: shades(), colorbar: {...trace.colorbar, len: 0.7, y: 0, yanchor: "bottom"}, showscale: !narrow()}
      : {...trace}));  // plotly writes into what it gets
    await Plotly.newPlot(place, data, layoutOf(picture.layout), options);
    drawn[name] = picture;
    if (picture.layout.across) {
      place.on("plotly_click", (event) => moveTo(nearest(event.points[0][picture.layout.across])));
    }
  };

  const cursor = report.cursor;
  const slider = document.getElementById("cursor");
  const readout = document.getElementById("readout");
  const nearest = (value) => cursor.place.reduce(
    (best, place, i) => (Math.abs(place - value) < Math.abs(cursor.place[best] - value) ? i : best), 0);
  const format = (value, digits = 4) => (value === null || value === undefined ? "\u2013"
    : value.toLocaleString(undefined, {maximumSignificantDigits: digits}));
  const summed = (steps) => { let sum = 0; return steps.map((step) => (sum += step)); };
  const path = (body, i) => {  // written as third differences
    const [x, y] = cursor.paths[body][i].map((steps) => summed(summed(summed(steps))).map((value) => value * cursor.scale[i]));
    return {x, y};
  };
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  const heat = report.pictures.campbell.data[0];
  const [, nBins] = heat.z.shape.split(", ").map(Number);
  const levels = Int8Array.from(atob(heat.z.bdata), (letter) => letter.charCodeAt(0));

  const orbitAt = (i) => {
    const rotor = path(0, i), stator = path(1, i), held = {x: [], y: []}, circle = {x: [], y: []};
    const middle = {x: mean(stator.x), y: mean(stator.y)};
    for (let k = 0; k <= 72; k++) {
      circle.x.push(middle.x + cursor.gap * Math.cos((Math.PI * k) / 36));
      circle.y.push(middle.y + cursor.gap * Math.sin((Math.PI * k) / 36));
    }
    cursor.touching[i].forEach((touches, k) => {
      held.x.push(touches ? rotor.x[k] : null);
      held.y.push(touches ? rotor.y[k] : null);
    });
    const marks = {x: cursor.marks[i].map((k) => rotor.x[k]), y: cursor.marks[i].map((k) => rotor.y[k])};
    return [circle, rotor, held, stator, marks];
  };
  // in steps, so that the axes stay while the path changes little
  const reachOf = (parts) => {
    const farthest = Math.max(...parts.flatMap((part) => part.x.map((x, k) => Math.hypot(x || 0, part.y[k] || 0))));
    return Math.pow(1.25, Math.ceil(Math.log(1.02 * farthest) / Math.log(1.25)));
  };
  const spectrumAt = (i) => {
    const place = heat.y.reduce((best, y, k) => (Math.abs(y - cursor.place[i]) < Math.abs(heat.y[best] - cursor.place[i]) ? k : best), 0);
    return Array.from(levels.subarray(place * nBins, (place + 1) * nBins));
  };
  const lineAt = (across, value) => ({
    type: "line", layer: "above", line: {color: style().ink, width: 1.5, dash: "dot"},
    ...(across === "x" ? {x0: value, x1: value, yref: "paper", y0: 0, y1: 1} : {y0: value, y1: value, xref: "paper", x0: 0, x1: 1}),
  });
  let waiting = false;
  const show = () => {
    waiting = false;
    const i = Number(slider.value);
    for (const [name, picture] of Object.entries(drawn)) {
      if (picture.layout.across) Plotly.relayout(name, {shapes: [lineAt(picture.layout.across, cursor.place[i])]});
    }
    const parts = orbitAt(i);
    Plotly.restyle("orbit", {x: parts.map((part) => part.x), y: parts.map((part) => part.y)});
    const reach = reachOf(parts);
    Plotly.relayout("orbit", {"xaxis.range": [-reach, reach], "yaxis.range": [-reach, reach]});
    Plotly.restyle("spectrum", {y: [spectrumAt(i)]});
    const {frequency, force} = cursor.units;
    const place = `${format(cursor.speed[i])} ${frequency}, ${format(cursor.time[i])} s`;
    Plotly.relayout("orbit", {"title.text": `orbit at ${place}`});
    Plotly.relayout("spectrum", {"title.text": `spectrum at ${place}`});
    const [f, fPredicted, a, aPredicted] = cursor.values.map((column) => column[i]);
    const whirl = f === null || cursor.verdict[i] === "no whirl" ? "no backward whirl" : `whirl ${cursor.branch[i]} ${format(f)} ${frequency} (predicted ${format(fPredicted)}), `
      + `${format(a)} ${cursor.unit} (predicted ${format(aPredicted)})`;
    readout.textContent = `${format(cursor.speed[i])} ${frequency}, ${frequency === "Hz" ? `${format(60 * cursor.speed[i])} rpm, ` : ""}${format(cursor.time[i])} s: ${whirl}, `
      + (cursor.force[i] === null ? "" : `contact ${format(100 * cursor.share[i], 3)} %, ${format(cursor.force[i], 3)} ${force}; `)
      + cursor.verdict[i];
    slider.setAttribute("aria-valuetext", readout.textContent);
  };
  const moveTo = (i) => {
    slider.value = i;
    if (!waiting) { waiting = true; requestAnimationFrame(show); }
  };

  // the run as a film: the cursor goes from where it is to the end, in SECONDS for the whole run
  const SECONDS = 20, play = document.getElementById("play");
  let from = null;  // {time in ms, place} where it began
  const pressed = (on) => {
    play.setAttribute("aria-pressed", String(on));
    play.textContent = on ? "Stop the run" : "Play the run";
  };
  const step = (now) => {
    if (from === null) return;
    const last = cursor.place.length - 1, i = Math.floor(from.place + last * (now - from.time) / (1000 * SECONDS));
    if (i >= last) { from = null; pressed(false); }
    if (Math.min(i, last) !== Number(slider.value)) moveTo(Math.min(i, last));
    requestAnimationFrame(step);
  };
  play.addEventListener("click", () => {
    const at = Number(slider.value);
    from = from === null ? {time: performance.now(), place: at < cursor.place.length - 1 ? at : 0} : null;
    pressed(from !== null);
    requestAnimationFrame(step);
  });

  const choose = document.getElementById("whirl");
  choose.addEventListener("change", () => {
    for (const [name, picture] of Object.entries(drawn)) {
      const opacity = picture.data.map((trace) => (choose.value && trace.meta && trace.meta !== choose.value ? 0.12 : 1));
      Plotly.restyle(name, {opacity});
    }
  });

  // mode shapes: every point on its ellipse, from where it is, at rest and a quarter of a period later
  const PERIOD = 2500;  // ms
  const shapes = () => Object.entries(drawn).filter(([, picture]) => picture.data.some((trace) => trace.rest));
  const turnTo = (phi) => {
    const at = (trace, letter) => trace.rest[letter].map((middle, k) => middle + (trace[letter][k] - middle) * Math.cos(phi)
      + (trace.quarter[letter][k] - middle) * Math.sin(phi));
    for (const [name, {data}] of shapes()) {
      const moving = data.map((trace, k) => k).filter((k) => data[k].rest);
      Plotly.restyle(name, {x: moving.map((k) => at(data[k], "x")), y: moving.map((k) => at(data[k], "y"))}, moving);
    }
  };
  const animate = document.getElementById("animate");
  let begun = null;
  const turn = (now) => {
    if (begun === null) return;
    turnTo(2 * Math.PI * ((now - begun) / PERIOD % 1));
    requestAnimationFrame(turn);
  };
  if (animate) animate.addEventListener("click", () => {
    begun = begun === null ? performance.now() : null;
    animate.setAttribute("aria-pressed", String(begun !== null));
    animate.textContent = begun === null ? "Animate the mode shapes" : "Stop the mode shapes";
    if (begun === null) turnTo(0); else requestAnimationFrame(turn);
  });

  const start = async () => {
    document.body.classList.add("on");
    for (const [name, picture] of Object.entries(report.pictures)) await draw(name, picture);
    const scatter = (name, color, mode = "lines") => ({type: "scatter", mode, name, x: [], y: [], line: {color, width: 1.4}});
    const marks = {...scatter("once a revolution", "#444444", "markers"), marker: {color: "#ffffff", size: 8, line: {color: "#444444", width: 1.5}}};
    const probes = cursor.force.every((force) => force === null);  // which see neither contact nor stator
    const unseen = (trace) => ({...trace, visible: !probes});
    const traces = [scatter("gap", "#8a8a8a"), scatter("rotor", "#0b7cc4"), unseen(scatter("in contact", "#d55e00")),
      unseen(scatter("stator", "#009e73")), marks];
    const reach = 1.05 * cursor.reach;
    const titled = (layout) => ({...layout, title: {text: "", font: {size: 13}, x: 0.02, y: 0.98, yanchor: "top"}, margin: {...layout.margin, t: 34}});
    const axis = (letter) => ({title: `${letter} in ${cursor.unit}`, range: [-reach, reach]});
    await Plotly.newPlot("orbit", traces, titled({...layoutOf({xaxis: axis("y"), yaxis: axis("z"), height: 400, equal: true}), showlegend: true}), options);
    const spectrum = {...scatter("amplitude", "#0b7cc4"), x: heat.x, y: heat.x, hovertemplate: `%{x:.2f} ${cursor.units.frequency}: %{y} dB<extra></extra>`};
    const lines = {xaxis: {title: `frequency in ${cursor.units.frequency} (backward < 0)`}, yaxis: {title: `amplitude in ${heat.colorbar.title.text}`, range: [heat.zmin, 2]}, height: 400};
    await Plotly.newPlot("spectrum", [spectrum], titled({...layoutOf(lines), showlegend: false}), options);
    slider.max = cursor.place.length - 1;
    slider.addEventListener("input", () => { from = null; pressed(false); moveTo(Number(slider.value)); });
    moveTo(Math.floor(cursor.place.length / 2));
    document.body.dataset.ready = "yes";
  };
  await start();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", async () => {
    for (const [name, picture] of Object.entries(report.pictures)) await draw(name, picture);
    for (const name of ["orbit", "spectrum"]) Plotly.relayout(name, {"font.color": style().ink});
    show();
  });
})();
