// Controls, the state they choose, drawing, sorting of tables and print.
"use strict";

const AXES = ["soil", "track", "train", "unevenness", "speed_kmh"];
const DECIBELS = {
  velocity: [[1e-9, "1e-9 m/s", "1e-9 m/s (ISO 1683)"], [1e-8, "1e-8 m/s", "1e-8 m/s"], [5e-8, "5e-8 m/s", "5e-8 m/s"],
    [2.54e-8, "2.54e-8 m/s", "1e-6 in/s (US VdB)"]],
  wheel_rail_force: [[1, "1 N", "1 N"], [1e-6, "1e-6 N", "1e-6 N (ISO 1683)"]],
};
const STORED = { velocity: 1e-9, wheel_rail_force: 1 };
const QUANTITIES = { velocity: "velocity", wheel_rail_force: "wheel–rail force" };
const select = (name) => document.getElementById(`select-${name}`);

function named(axisName, value) {
  return axisName === "speed_kmh" ? `${value} km/h` : String(value);
}

function nameOfCase(number) {
  return AXES.filter((name) => page.axes[name].length > 1 || name === "soil")
    .map((name) => named(name, page.axes[name][page.cases[number][AXES.indexOf(name)]])).join(", ");
}

/** Offer these choices, [value, text]; keep the present one where it is still there. */
function offer(name, choices, preset) {
  const element = select(name), before = element.value;
  element.replaceChildren(...choices.map(([value, text]) => new Option(text, value)));
  const values = choices.map(([value]) => String(value));
  element.value = values.includes(before) ? before : values.includes(String(preset)) ? String(preset) : values[0] ?? "";
}

function offerOfQuantity() {
  const quantity = select("quantity").value;
  const receivers = receiversOf(quantity, () => true);
  offer("receiver", receivers.map((number) => [number, page.receivers[number].label]), receivers[0]);
  offer("decibel", (DECIBELS[quantity] ?? []).map(([value, , text]) => [value, text]));
  const there = page.contributions.map((name, number) => [number, name]).filter(([number]) =>
    quantity === "velocity" || number === 0);
  offer("contribution", there, 0);
}

function decibelOf(quantity, state) {
  const [value, label] = state.decibel && state.quantity === quantity ? [state.decibel.value, state.decibel.label]
    : DECIBELS[quantity][0];
  return { value, label, stored: STORED[quantity] };
}

function offerAll() {
  const quantities = [...new Set(page.receivers.map((each) => each.quantity))];
  offer("quantity", quantities.map((name) => [name, QUANTITIES[name] ?? name]), "velocity");
  offerOfQuantity();
  for (const name of AXES) offer(name, page.axes[name].map((value, place) => [place, named(name, value)]));
  offer("band", [[-1, "all bands"], ...page.band_names.map((name, band) => [band, `${name} Hz`])]);
  const others = page.approaches.map((approach, number) => [number, approach.label]).filter(([number]) => number !== reference);
  offer("heat-approach", others);
  const rows = [["speed_kmh", "speed"], ["receiver", "receiver"], ["soil", "soil"]];
  offer("heat-rows", rows, page.axes.speed_kmh.length > 1 ? "speed_kmh" : "receiver");
  offer("cost", [["whole", "whole case"], ["marginal", "one more speed"]]);
}

function stateNow() {
  const quantity = select("quantity").value;
  const value = Number(select("decibel").value);
  const label = (DECIBELS[quantity] ?? []).find((each) => each[0] === value)?.[1] ?? "";
  return {
    quantity, receiver: Number(select("receiver").value), contribution: Number(select("contribution").value),
    case: findCase(AXES.map((name) => Number(select(name).value))), decibel: { value, label, stored: STORED[quantity] ?? 1 },
    approaches: [...document.querySelectorAll("input[name=approach]:checked")].map((box) => Number(box.value))
      .sort((a, b) => (b === reference) - (a === reference)),  // the reference underneath the others
    band: Number(select("band").value), heatApproach: select("heat-approach").value === "" ? -1 : Number(select("heat-approach").value),
    heatRows: select("heat-rows").value, cost: select("cost").value,
  };
}

function draw(names = Object.keys(figures)) {
  const state = stateNow();
  const receiver = page.receivers[state.receiver];
  const about = state.case < 0 ? "This combination is not in the study." :
    `Shown: ${AXES.map((name) => named(name, page.axes[name][page.cases[state.case][AXES.indexOf(name)]])).join(", ")}; ` +
    `${receiver?.label ?? ""}, ${page.contributions[state.contribution]}, dB re ${state.decibel.label}.`;
  document.getElementById("shown").textContent = about;
  for (const name of names) {
    const element = document.getElementById(`plot-${name}`);
    const figure = state.case < 0 ? nothing("this combination is not in the study") : figures[name](state);
    const title = document.querySelector(`#figure-${name} h3`).textContent;
    element.setAttribute("aria-label", `${title}. ${about} Numbers are in the tables below.`);
    document.getElementById(`note-${name}`).textContent = figure.note ?? "";
    Plotly.react(element, figure.traces, figure.layout, CONFIG);
  }
}

const OWN = { "select-band": ["distance"], "select-heat-approach": ["heat"], "select-heat-rows": ["heat"], "select-cost": ["cost"] };

function sortBy(button) {
  const heading = button.closest("th"), table = button.closest("table");
  const column = [...heading.parentNode.children].indexOf(heading);
  const down = heading.getAttribute("aria-sort") === "ascending";
  const key = (row) => row.cells[column].textContent.trim();
  const numeric = (text) => (/^[-+−]?[\d.,]+( ×)?$/.test(text) ? Number(text.replace("−", "-").replace(/[,×\s]/g, "")) : null);
  const rows = [...table.tBodies[0].rows].map((row) => [numeric(key(row)), key(row), row]);
  rows.sort(([a, textA], [b, textB]) => {
    if ((a === null) !== (b === null)) return a === null ? 1 : -1;
    const order = a === null ? textA.localeCompare(textB, "en", { numeric: true }) : a - b;
    return down ? -order : order;
  });
  table.tBodies[0].append(...rows.map(([, , row]) => row));
  for (const other of heading.parentNode.children) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", down ? "descending" : "ascending");
}

document.addEventListener("change", (event) => {
  if (event.target.id === "select-quantity") offerOfQuantity();
  if (event.target.matches("select, input")) draw(OWN[event.target.id]);
});
document.addEventListener("submit", (event) => event.preventDefault());
for (const button of document.querySelectorAll(".sortable th button")) button.addEventListener("click", () => sortBy(button));

addEventListener("beforeprint", () => {
  printing = true;
  draw();
  for (const plot of document.querySelectorAll(".plot")) Plotly.relayout(plot, { width: PRINT_WIDTH, autosize: false });
});
addEventListener("afterprint", () => {
  printing = false;
  draw();
  for (const plot of document.querySelectorAll(".plot")) Plotly.relayout(plot, { width: null, autosize: true });
});
let wide = innerWidth;
addEventListener("resize", () => {
  if (printing || innerWidth === wide) return;
  wide = innerWidth;
  draw();  // the number of columns follows the width
  for (const plot of document.querySelectorAll(".plot")) Plotly.Plots.resize(plot);
});

offerAll();
draw();
document.documentElement.dataset.ready = "yes";
