// The numbers of the page: levels in hundredths of a decibel, unpacked once.
"use strict";

const page = JSON.parse(document.getElementById("data").textContent);
const NONE = -32768;

function unpack(text) {
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let at = 0; at < letters.length; at += 1) bytes[at] = letters.charCodeAt(at);
  return new Int16Array(bytes.buffer);
}

const packedLevels = unpack(page.levels);
for (const spectra of page.lines.spectra) spectra.packed = unpack(spectra.levels);
const spectraOfCase = new Map(page.lines.spectra.map((spectra) => [spectra.case, spectra]));

/** Return the levels of all bands, null where there is none: dB re 1e-9 m/s or 1 N. */
function levels(caseNumber, approach, contribution, receiver) {
  const bands = page.bands.length;
  const start = (((caseNumber * page.approaches.length + approach) * page.contributions.length + contribution) *
    page.receivers.length + receiver) * bands;
  return Array.from(packedLevels.subarray(start, start + bands), (value) => (value === NONE ? null : value / 100));
}

/** Return of every band whether more than half of the unevenness behind it is extrapolated. */
function extrapolated(caseNumber) {
  const numbers = new Set(page.extrapolated[caseNumber]);
  return page.bands.map((_, band) => numbers.has(band));
}

/** Return what may be averaged with a receiver: all axles, the rail, or the ground at all offsets. */
function placeOf(receiver) {
  const { quantity, receiver: name } = page.receivers[receiver] ?? {};
  return quantity === "wheel_rail_force" ? "force" : name;
}

/** Return frequency and level of a narrow-band spectrum, or null: its lines, or the extremes of its bins in turn. */
function spectrum(caseNumber, approach, contribution, receiver) {
  const spectra = spectraOfCase.get(caseNumber);
  if (!spectra) return null;
  const place = approach * page.contributions.length + contribution;
  const number = spectra.places.findIndex((each, at) => each === place && spectra.receivers[at] === receiver);
  if (number < 0) return null;
  const each = page.lines.bins ? 2 : 1;
  const size = spectra.frequency.length * each;
  const values = spectra.packed.subarray(number * size, (number + 1) * size);
  const frequency = [], level = [];
  values.forEach((value, at) => {
    if (value !== NONE) {
      frequency.push(spectra.frequency[Math.floor(at / each)]);
      level.push(value / 100);
    }
  });
  return { frequency, level };
}

/** Return the sum of levels over bands, null where none is there. */
function overall(values) {
  const sum = values.reduce((total, level) => (level === null ? total : total + 10 ** (level / 10)), 0);
  return sum > 0 ? 10 * Math.log10(sum) : null;
}

const reference = page.approaches.findIndex((approach) => approach.name === page.reference);

/** Return the error of an approach in every band, dB; null where it or the reference is missing. */
function errors(caseNumber, approach, contribution, receiver) {
  if (reference < 0) return page.bands.map(() => null);
  const against = levels(caseNumber, reference, contribution, receiver);
  return levels(caseNumber, approach, contribution, receiver).map((level, band) =>
    (level === null || against[band] === null ? null : level - against[band]));
}

/** Return the number of the case at these places on the axes, or -1. */
function findCase(places) {
  return page.cases.findIndex((each) => each.every((place, axis) => place === places[axis]));
}
