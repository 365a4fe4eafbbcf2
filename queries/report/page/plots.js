// How every plot looks, and the parts that several of them share.
"use strict";

const TEXT = "#1b1f24", QUIET = "#515a64", GRID = "#e4e8ec";
const PRINT_WIDTH = 680;  // px of an A4 page between its margins
let printing = false;
const viewWidth = () => (printing ? PRINT_WIDTH : innerWidth);
const CONFIG = { responsive: true, displayModeBar: false, doubleClick: "reset" };

function axis(title, more = {}) {
  return {
    title: { text: title, font: { size: 13, color: QUIET }, standoff: 8 }, gridcolor: GRID, zeroline: false,
    linecolor: "#8a939d", ticks: "outside", tickcolor: "#8a939d", ticklen: 4, tickfont: { size: 12, color: TEXT },
    automargin: true, ...more,
  };
}

/** An axis over one-third octaves, a name at each octave. */
function bandAxis(title, more = {}) {
  const first = Math.log10(page.bands[0] ?? 1), last = Math.log10(page.bands[page.bands.length - 1] ?? 100);
  const named = page.bands.map((_, band) => band).filter((band) => band % 3 === 0);
  return axis(title, {
    type: "log", range: [first - 0.05, last + 0.05], tickvals: named.map((band) => page.bands[band]),
    ticktext: named.map((band) => page.band_names[band]), ...more,
  });
}

function layout(height, more = {}) {
  return {
    height, margin: { l: 58, r: 14, t: 34, b: 48 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff",
    font: { family: "system-ui, -apple-system, 'Segoe UI', Roboto, 'Liberation Sans', sans-serif", size: 13, color: TEXT },
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", itemclick: false, itemdoubleclick: false,
      font: { size: 12.5 } },
    hoverlabel: { bgcolor: "#fff", bordercolor: "#8a939d", font: { color: TEXT } }, ...more,
  };
}

/** The line of an approach, the same wherever it is drawn. */
function curve(approach, x, y, more = {}) {
  const style = page.approaches[approach];
  return {
    x, y, name: style.label, mode: "lines+markers", legendgroup: style.name,
    line: { color: style.colour, dash: style.dash, width: style.width },
    marker: { color: style.colour, symbol: style.symbol, size: style.size }, ...more,
  };
}

/** A line of levels over bands, with hollow markers where unevenness is mostly extrapolated. */
function levelCurve(approach, state, contribution, values, more = {}) {
  const style = page.approaches[approach];
  const hollow = page.contributions[contribution] === "quasi-static" ? [] : extrapolated(state.case);
  const marker = { symbol: style.symbol, size: style.size, line: { color: style.colour, width: 1.4 },
    color: page.bands.map((_, band) => (hollow[band] ? "#fff" : style.colour)) };
  return curve(approach, page.bands, values, { marker, ...more });
}

/** A note in place of a plot that has nothing to show. */
function nothing(text) {
  const hidden = { visible: false };
  const note = { text: escaped(text), showarrow: false, font: { size: 14, color: QUIET }, x: 0.5, y: 0.5, xref: "paper", yref: "paper" };
  return { traces: [], layout: layout(300, { xaxis: hidden, yaxis: hidden, annotations: [note] }) };
}

/** Plotly reads a few HTML tags in texts: names are shown as they are. */
function escaped(text) {
  return String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

/** Panels side by side and below each other, each with a title; the axes of panel n are x{n} and y{n}. */
function panels(titles, columns, height, labels, axes, gap = 0.07) {
  const rows = Math.ceil(titles.length / columns);
  const result = { annotations: [] };
  // The legend stands above the titles, in as many lines as its entries need.
  const room = Math.min(viewWidth(), 1280) / (gap > 0.1 ? 2 : 1) - 100;
  const legendLines = Math.ceil(labels.reduce((sum, label) => sum + 55 + 7 * label.length, 0) / room);
  const above = 30 + 21 * legendLines, inside = rows * height - 40;
  const gapX = columns > 1 ? gap : 0, gapY = rows > 1 ? 76 / inside : 0;
  const wide = (1 - gapX * (columns - 1)) / columns, high = (1 - gapY * (rows - 1)) / rows;
  titles.forEach((title, at) => {
    const row = Math.floor(at / columns), column = at % columns;
    const left = column * (wide + gapX), top = 1 - row * (high + gapY);
    const n = at ? at + 1 : "";
    const [x, y] = axes(at, column === 0, at + columns >= titles.length);
    result[`xaxis${n}`] = { ...x, domain: [left, left + wide], anchor: `y${n}` };
    result[`yaxis${n}`] = { ...y, domain: [Math.max(top - high, 0), top], anchor: `x${n}` };
    result.annotations.push({ text: escaped(title), showarrow: false, xref: "paper", yref: "paper", x: left, y: top,
      xanchor: "left", yanchor: "bottom", font: { size: 12.5, color: TEXT } });
  });
  return layout(inside + above + 48, { ...result, margin: { l: 58, r: 14, t: above, b: 48 },
    legend: { ...layout(0).legend, yref: "container", y: 1, yanchor: "top" } });
}

/** Ticks at 1, 2 and 5 in every decade between two ends, with plain numbers. */
function decades(lowest, highest) {
  const values = [];
  for (let power = Math.floor(Math.log10(lowest)); power <= Math.ceil(Math.log10(highest)); power += 1) {
    for (const digit of [1, 2, 5]) values.push(digit * 10 ** power);
  }
  return { tickvals: values, ticktext: values.map((value) => String(Number(value.toPrecision(3)))) };
}
