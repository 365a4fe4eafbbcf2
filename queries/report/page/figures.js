// The figures: each is made anew from the chosen state and returns traces and layout.
"use strict";

/** Decibels to add for the chosen reference; levels are stored re 1e-9 m/s and 1 N. */
function shift(state) {
  return -20 * Math.log10(state.decibel.value / state.decibel.stored);
}

function levelTitle(state, what = "level") {
  return `${what} [dB re ${state.decibel.label}]`;
}

function shifted(values, by) {
  return values.map((value) => (value === null ? null : value + by));
}

function receiversOf(quantity, keep) {
  return page.receivers.map((_, number) => number).filter((number) =>
    page.receivers[number].quantity === quantity && keep(page.receivers[number]));
}

const some = (values) => values.some((value) => value !== null);

const figures = {
  levels(state) {
    const traces = [];
    let compared = false;
    for (const approach of state.approaches) {
      const level = levels(state.case, approach, state.contribution, state.receiver);
      if (some(level)) traces.push(levelCurve(approach, state, state.contribution, shifted(level, shift(state)), { hovertemplate: "%{y:.1f} dB" }));
      const error = approach === reference ? [] : errors(state.case, approach, state.contribution, state.receiver);
      if (some(error)) {
        traces.push(curve(approach, page.bands, error, { yaxis: "y2", showlegend: false, hovertemplate: "%{y:+.1f} dB" }));
        compared = true;
      }
    }
    if (!traces.length) return nothing("no results here");
    const top = compared ? 0.38 : 0;
    const both = { hovermode: "x unified", xaxis: bandAxis("one-third octave [Hz]", { anchor: compared ? "y2" : "y" }),
      yaxis: axis(levelTitle(state), { domain: [top, 1] }) };
    if (compared) both.yaxis2 = axis("error [dB]", { domain: [0, 0.29], zeroline: true, zerolinecolor: "#8a939d" });
    return { traces, layout: layout(480, both) };
  },

  narrow(state) {
    const traces = [];
    let peak = -Infinity;
    for (const approach of state.approaches) {
      const lines = spectrum(state.case, approach, state.contribution, state.receiver);
      if (!lines) continue;
      const level = shifted(lines.level, shift(state));
      peak = level.reduce((most, value) => Math.max(most, value), peak);
      traces.push(curve(approach, lines.frequency, level, { mode: "lines", opacity: approach === reference ? 0.6 : 1,
        line: { color: page.approaches[approach].colour, width: approach === reference ? 1 : 1.4 },
        hovertemplate: "%{x:.2f} Hz: %{y:.1f} dB" }));
    }
    if (!traces.length) return nothing("no narrow-band lines of this receiver, contribution and case in this page");
    const { shapes, notes, note } = passing(state);
    return { note, traces, layout: layout(400, { xaxis: bandAxis("frequency [Hz]"), shapes, annotations: notes,
      yaxis: axis(`density [dB re (${state.decibel.label})²/Hz]`, { range: [peak - 75, peak + 4] }) }) };
  },

  force(state) {
    const axles = ["axle-1", "axle-2"].map((name) => receiversOf("wheel_rail_force", (each) => each.receiver === name)[0]);
    return small(state, axles.filter((receiver) => receiver !== undefined), ["leading axle of the leading bogie",
      "trailing axle of the leading bogie"], 2, 290, "wheel_rail_force");
  },

  places(state) {
    const every = receiversOf("velocity", () => true);
    const receivers = sample(every, 12);
    const labels = receivers.map((number) => page.receivers[number].label);
    return { ...small(state, receivers, labels, 3, 240, "velocity"), note: shownOf(receivers, every, "receivers") };
  },

  distance(state) {
    const ground = receiversOf("velocity", (each) => each.receiver === "ground");
    const traces = state.approaches.map((approach) => {
      const level = ground.map((receiver) => {
        const all = levels(state.case, approach, state.contribution, receiver);
        return state.band < 0 ? overall(all) : all[state.band];
      });
      const by = shift({ decibel: decibelOf("velocity", state) });
      return curve(approach, ground.map((receiver) => page.receivers[receiver].offset_m), shifted(level, by),
        { hovertemplate: "%{x} m: %{y:.1f} dB" });
    }).filter((trace) => some(trace.y));
    if (!traces.length) return nothing("no results on the ground here");
    return { traces, layout: layout(360, { xaxis: axis("distance from the track's centre [m]", { rangemode: "tozero" }),
      yaxis: axis(levelTitle({ decibel: decibelOf("velocity", state) })) }) };
  },

  heat(state) {
    const rows = [];
    const places = page.cases[state.case] ?? [];
    if (state.heatRows === "receiver") {
      for (const receiver of receiversOf(page.receivers[state.receiver]?.quantity, () => true)) {
        rows.push([page.receivers[receiver].label, state.case, receiver]);
      }
    } else {
      const at = AXES.indexOf(state.heatRows);
      page.axes[state.heatRows].forEach((value, place) => {
        const number = findCase(places.map((each, axisNumber) => (axisNumber === at ? place : each)));
        if (number >= 0) rows.push([named(state.heatRows, value), number, state.receiver]);
      });
    }
    const z = rows.map(([, number, receiver]) => errors(number, state.heatApproach, state.contribution, receiver));
    if (state.heatApproach < 0 || !z.some(some)) return nothing("no errors here: the approach or the reference has no results");
    const limit = Math.max(3, Math.min(15, ...[Math.max(...z.flat().filter((value) => value !== null).map(Math.abs))]));
    const written = rows.length <= 12 && viewWidth() > 700;
    return { traces: [{ type: "heatmap", z, x: page.band_names, y: rows.map((row) => escaped(row[0])), zmid: 0, zmin: -limit, zmax: limit,
      colorscale: [[0, "#4393c3"], [0.25, "#92c5de"], [0.5, "#f7f7f7"], [0.75, "#f4a582"], [1, "#d6604d"]], xgap: 1, ygap: 1,
      ...(written ? { texttemplate: "%{z:.0f}", textfont: { size: 11, color: "#000" } } : {}),
      hovertemplate: "%{y}, %{x} Hz: %{z:+.1f} dB<extra></extra>",
      colorbar: { title: { text: "dB", font: { size: 12 } }, thickness: 12, outlinewidth: 0, tickfont: { size: 12 } } }],
    layout: layout(Math.max(220, 110 + 30 * Math.min(rows.length, 18)), { xaxis: axis("one-third octave [Hz]", { type: "category", tickangle: 0, tickvals: page.band_names.filter((_, band) => band % (viewWidth() > 700 ? 1 : 3) === 0) }),
      yaxis: axis("", { type: "category", autorange: "reversed", ticks: "" }), margin: { l: 30, r: 10, t: 14, b: 48 } }) };
  },

  cost(state) {
    const receivers = page.receivers.map((_, number) => number).filter((number) => placeOf(number) === placeOf(state.receiver));
    const traces = [];
    for (const approach of state.approaches) {
      const points = [];
      for (const [number, each, whole, cpu, marginal] of page.costs) {
        const cost = state.cost === "whole" ? cpu : marginal;
        if (each !== approach || !whole || !(cost > 0)) continue;
        const sizes = approach === reference ? [0] :
          receivers.flatMap((receiver) => errors(number, approach, state.contribution, receiver)).filter((value) => value !== null);
        if (!sizes.length) continue;
        const mean = sizes.reduce((sum, value) => sum + Math.abs(value), 0) / sizes.length;
        points.push({ cost, mean, number });
      }
      if (!points.length) continue;
      traces.push(curve(approach, points.map((point) => point.cost), points.map((point) => point.mean), { mode: "markers", cliponaxis: false,
        marker: { ...curve(approach).marker, size: points.map((point) => (point.number === state.case ? 15 : 8)), opacity: 0.85,
          line: { color: "#fff", width: 1 } },
        text: points.map((point) => escaped(nameOfCase(point.number))), hovertemplate: "%{text}<br>%{x:.3g} CPU s, mean |error| %{y:.1f} dB" }));
    }
    if (!traces.length) return nothing("no costs beside errors here");
    const all = traces.flatMap((trace) => trace.x);
    const ends = [Math.log10(Math.min(...all)) - 0.15, Math.log10(Math.max(...all)) + 0.15];
    return { traces, layout: layout(360, { xaxis: axis(state.cost === "whole" ? "processor time of a case [s]" : "processor time of one more speed [s]",
      { type: "log", range: ends, ...decades(Math.min(...all), Math.max(...all)) }), yaxis: axis("mean |error| [dB]", { rangemode: "tozero" }) }) };
  },

  receptance(state) {
    const [soil, track] = AXES.slice(0, 2).map((name) => page.axes[name][page.cases[state.case]?.[AXES.indexOf(name)]]);
    const speed = page.axes.speed_kmh[page.cases[state.case]?.[4]];
    const curves = page.receptances.filter((each) => each.soil === soil && each.track === track &&
      (each.speed_kmh === 0 || Math.abs(each.speed_kmh - speed) < 1e-6));
    if (!curves.length) return nothing("no receptance of this soil, track and speed");
    const traces = curves.flatMap((each) => {
      const still = each.speed_kmh === 0;
      const line = { color: still ? "#000000" : "#0072B2", dash: still ? "solid" : "10px,3px", width: 1.8 };
      const common = { mode: "lines", line, x: each.frequency, name: still ? "standing load" : `load moving at ${each.speed_kmh} km/h` };
      return [{ ...common, y: each.magnitude, hovertemplate: "%{x:.3g} Hz: %{y:.3g}e-9 m/N" },
        { ...common, y: each.phase, xaxis: "x2", yaxis: "y2", showlegend: false, hovertemplate: "%{x:.3g} Hz: %{y:.3g} rad" }];
    });
    const rows = panels(["magnitude", "phase"], viewWidth() > 560 ? 2 : 1, 290, ["standing load", "load moving at 150 km/h"], (at, _, bottom) =>
      [bandAxis(bottom ? "frequency [Hz]" : ""), axis(at ? "phase [rad]" : "magnitude [1e-9 m/N]", at ? {} : { rangemode: "tozero" })], 0.17);
    return { traces, layout: rows };
  },

  unevenness(state) {
    if (!page.unevenness.length) return nothing("no unevenness");
    const chosen = page.axes.unevenness[page.cases[state.case]?.[3]];
    const colours = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#8a6d00"];
    const traces = page.unevenness.map((each, number) => {
      const colour = colours[number % colours.length];
      return { x: each.wavelength, y: each.level, name: escaped(each.name), mode: "lines+markers", showlegend: true,
        line: { color: colour, width: each.name === chosen ? 2.4 : 1.2 },
        marker: { size: 7, color: each.extrapolated.map((share) => (share > 0.5 ? "#ffffff" : colour)), line: { color: colour, width: 1.5 } },
        hovertemplate: "%{x:.3g} m: %{y:.1f} dB" };
    });
    return { traces, layout: layout(360, { xaxis: axis("wavelength [m]", { type: "log", autorange: "reversed", ...decades(0.01, 1000) }),
      yaxis: axis("level [dB re 1e-6 m]") }) };
  },
};

/** A panel per receiver, with a line per approach and one range of levels. */
function small(state, receivers, titles, most, height, quantity) {
  const columns = Math.min(most, receivers.length, viewWidth() > 900 ? most : viewWidth() > 560 ? 2 : 1);
  const decibel = decibelOf(quantity, state);
  const contribution = quantity === "velocity" ? state.contribution : 0;
  const traces = [];
  receivers.forEach((receiver, at) => {
    for (const approach of state.approaches) {
      const level = levels(state.case, approach, contribution, receiver);
      const n = at ? at + 1 : "";
      if (some(level)) traces.push(levelCurve(approach, state, contribution, shifted(level, shift({ decibel })), { xaxis: `x${n}`, yaxis: `y${n}`,
        hovertemplate: "%{y:.1f} dB", showlegend: !traces.some((trace) => trace.legendgroup === page.approaches[approach].name) }));
    }
  });
  if (!traces.length) return nothing("no results here");
  const title = levelTitle({ decibel });
  const labels = state.approaches.map((approach) => page.approaches[approach].label);
  return { traces, layout: panels(titles, columns, height, labels, (at, left, bottom) =>
    [bandAxis(bottom ? "one-third octave [Hz]" : ""), axis(left ? title : "", at ? { matches: "y" } : {})]) };
}

/** Return at most so many items, evenly spread. */
function sample(items, most) {
  if (items.length <= most) return items;
  return Array.from({ length: most }, (_, place) => items[Math.round(place * (items.length - 1) / (most - 1))]);
}

/** Return how many of some things are shown, or nothing if all are. */
function shownOf(shown, every, what) {
  return shown.length < every.length ? `${shown.length} of ${every.length} ${what} are shown.` : "";
}

const PASSING = [["#b9a7c9", "solid"], ["#8fb5a8", "dash"], ["#d0a88a", "dashdot"]];

/** Lines at the frequencies at which vehicles of each length, and axles, pass a fixed point. */
function passing(state) {
  const every = page.trains[page.axes.train[page.cases[state.case]?.[2]]] ?? [];
  const speed = page.axes.speed_kmh[page.cases[state.case]?.[4]] / 3.6;
  const kinds = every.slice(0, PASSING.length);
  const marks = kinds.map(({ length, count }, kind) => [length, 8, ...PASSING[kind],
    `v/${length} m, ${count} vehicle${count > 1 ? "s" : ""}`]);
  if (kinds.length) marks.push([kinds[0].axles, 4, "#b9a7c9", "dot", "v/axles"]);
  const shapes = [], notes = [];
  const lowest = page.bands[0] * 10 ** -0.05, highest = page.bands[page.bands.length - 1] * 10 ** 0.05;
  marks.forEach(([distance, multiples, color, dash, label], line) => {
    if (!distance) return;
    for (let n = 1; n <= multiples; n += 1) {
      const frequency = n * speed / distance;
      if (frequency < lowest || frequency > highest) continue;
      shapes.push({ type: "line", x0: frequency, x1: frequency, y0: 0, y1: 1, yref: "paper", layer: "below",
        line: { color, width: 1.2, dash } });
      if (n === 1) notes.push({ x: Math.log10(frequency), y: 0.01 + 0.06 * line, yref: "paper", xanchor: "left", yanchor: "bottom",
        showarrow: false, text: `${label} = ${frequency.toPrecision(3)} Hz`, font: { size: 12, color: QUIET }, bgcolor: "rgba(255,255,255,0.85)" });
    }
  });
  return { shapes, notes, note: shownOf(kinds, every, "lengths of vehicles") };
}
