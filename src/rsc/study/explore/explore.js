"use strict";
const $ = (id) => document.getElementById(id);
const values = {}, shown = [], steps = [], busy = {}, again = {};
let handles = {}, before = {}, last = {}, mapTimer = 0, polling = 0, moving = null, takes = [];

async function ask(part, more = {}) {
  const answer = await fetch(part, {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify({values, ...more})});
  if (!answer.ok) throw new Error(answer.status === 503 ? "busy" : "the server refused: " + answer.status);
  return answer.json();
}

const say = (text) => { $("error").textContent = text || ""; };

function draw(id, picture, old) {
  if (!picture) { Plotly.purge(id); $(id).textContent = "Not live for several contacts: see the words below."; return; }
  const layout = {...picture.layout, height: undefined, autosize: true, margin: {t: 10, r: 10, l: 55, b: 45}, showlegend: false};
  for (const axis of ["xaxis", "yaxis"]) layout[axis] = {...layout[axis], title: {text: layout[axis].title}};
  if (layout.equal) layout.yaxis.scaleanchor = "x";
  const past = (old ? old.data : []).filter((t) => t.type === "scatter" && t.name !== "gap").map((t) => ({...t, name: "before", opacity: 0.5,
    line: {...(t.line || {}), color: "#9aa2ab"}, marker: {...(t.marker || {}), color: "#c3c9cf", line: {color: "#9aa2ab", width: 1}}}));
  if (id === "whirls") layout.shapes = [{type: "line", x0: values.speed, x1: values.speed, yref: "paper", y0: 0, y1: 1, line: {color: "#0b5d94", width: 1}}];
  Plotly.react(id, [...past, ...picture.data], layout, {responsive: true, displayModeBar: false});
}

// of moves while an answer is on its way only the last one is asked for
async function follow(part, use, more) {
  if (busy[part]) { again[part] = true; return; }
  busy[part] = true;
  const began = performance.now();
  try {
    const answer = await ask(part, more && more());
    if (answer.error) { say(answer.error); } else { use(answer); }
    busy[part] = false;
    if (part === "whirls") took(performance.now() - began);
    return !answer.error;
  } catch (error) { say(String(error.message || error)); } finally {
    busy[part] = false;
    if (again[part]) { again[part] = false; follow(part, use, more); }
  }
}

function took(ms) {
  takes.push(ms);
  $("took").textContent = `whirls shown ${ms.toFixed(0)} ms after the last move`;
  document.body.dataset.moves = takes.length;
}

function use_words(a) { $("verdict").textContent = a.verdict; $("words").textContent = a.words; }
function use_whirls(a) { last.whirls = a.picture; draw("whirls", a.picture, before.whirls); }
function use_run(a) {
  last.orbit = a.orbit; last.spectrum = a.spectrum; $("run_words").textContent = a.words;
  draw("orbit", a.orbit, before.orbit); draw("spectrum", a.spectrum, before.spectrum);
  $("s_orbit").classList.remove("late"); $("s_spectrum").classList.remove("late");
}
function use_map(a) { draw("map", a.picture); $("s_map").classList.remove("late"); $("map_words").textContent = "Of predicted, stable whirls; white: none."; }

function update() {
  say("");
  location.replace("#" + encodeURIComponent(JSON.stringify(values)));
  for (const id of ["s_orbit", "s_spectrum", "s_map"]) $(id).classList.add("late");
  $("map_words").textContent = "Being computed: it follows when nothing moves.";
  const first = follow("whirls", use_whirls), second = follow("words", use_words), third = follow("run", use_run);
  clearTimeout(mapTimer);
  mapTimer = setTimeout(() => follow("map", use_map, () => ({x: $("map_x").value, y: $("map_y").value})), 300);
  return Promise.all([first, second, third]);
}

function show(name) {
  if (shown.includes(name)) return;
  shown.push(name);
  const h = handles[name], box = document.createElement("div"), label = document.createElement("label"), row = document.createElement("div");
  const range = document.createElement("input"), number = document.createElement("input"), unit = document.createElement("span");
  box.className = "handle"; label.textContent = name + " "; unit.textContent = h.unit ? "in " + h.unit : ""; label.append(unit); label.title = h.meaning;
  range.type = "range"; range.min = h.low; range.max = h.high; range.step = (h.high - h.low) / 500; range.id = "range_" + name; label.htmlFor = range.id;
  number.type = "number"; number.step = "any"; number.setAttribute("aria-label", name);
  h.set = (v) => { range.value = v; number.value = +(h.factor * v).toPrecision(6); };
  const remember = () => { if (moving === null) { moving = JSON.stringify(values); } };
  const moved = (v) => { if (v === "" || !isFinite(v)) return; remember(); values[name] = +v; h.set(v); update(); };
  range.oninput = () => moved(range.value);
  range.onchange = number.onblur = () => { if (moving !== null && moving !== JSON.stringify(values)) { steps.push(moving); $("undo").disabled = false; } moving = null; };
  number.onchange = () => { moved(number.value === "" ? "" : number.value / h.factor); number.onblur(); };
  row.append(range, number); box.append(label, row); $("handles").append(box); h.set(values[name] ?? h.value);
}

function take(wanted) {
  for (const name of Object.keys(values)) if (!(name in wanted)) { delete values[name]; handles[name].set && handles[name].set(handles[name].value); }
  for (const [name, v] of Object.entries(wanted)) if (name in handles && isFinite(v)) { values[name] = +v; show(name); handles[name].set(v); }
  if (!("speed" in values)) values.speed = handles.speed.value;
  handles.speed.set(values.speed);
  return update();
}

function of_address() { try { return JSON.parse(decodeURIComponent(location.hash.slice(1))) || {}; } catch { return {}; } }

async function poll() {
  const told = await ask("listed");
  $("list_words").textContent = {running: `Runs: ${told.ended} of ${told.of || "?"} have ended.`, done: "Done, for the values when it was asked for.",
    failed: "Failed.", stopped: "Stopped.", none: ""}[told.state] || "";
  if (told.words) $("listed").textContent = told.words;
  if (told.state === "running") polling = setTimeout(poll, 500);
}

function search() {
  const wanted = $("search").value.toLowerCase();
  const found = wanted ? Object.values(handles).filter((h) => !shown.includes(h.name) && (h.name + " " + h.meaning).toLowerCase().includes(wanted)) : [];
  $("found").replaceChildren(...found.slice(0, 12).map((h) => {
    const button = document.createElement("button");
    button.textContent = h.name; button.title = h.meaning;
    button.onclick = () => { show(h.name); $("search").value = ""; search(); };
    return button;
  }));
}

async function begin() {
  const told = await ask("begin");
  document.title = told.title + ": rsc explore"; $("title").textContent = told.title;
  for (const h of told.handles) handles[h.name] = h;
  for (const id of ["map_x", "map_y"]) for (const name of Object.keys(handles)) $(id).add(new Option(name, name));
  $("map_x").value = "speed"; $("map_y").value = "contact.friction" in handles ? "contact.friction" : Object.keys(handles)[1];
  $("map_x").onchange = $("map_y").onchange = () => update();
  values.speed = handles.speed.value;
  for (const h of told.handles) if (h.first) show(h.name);
  await take(of_address());
  before = {...last};
  $("undo").onclick = () => { const past = steps.pop(); $("undo").disabled = !steps.length; if (past) take(JSON.parse(past)); };
  $("reset").onclick = () => { steps.push(JSON.stringify(values)); $("undo").disabled = false; take({}); };
  $("keep").onclick = () => { before = {...last}; update(); };
  $("save").onclick = async () => {
    const answer = await ask("toml");
    if (answer.error) return say(answer.error);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([answer.text], {type: "text/plain"})); link.download = "explored.toml"; link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  $("list").onclick = async () => {
    const answer = await ask("list");
    if (answer.error) return say(answer.error);
    $("listed").textContent = ""; clearTimeout(polling); setTimeout(poll, 300);
  };
  $("search").oninput = search;
  document.body.dataset.ready = "yes";
}
begin().catch((error) => say(String(error.message || error)));
