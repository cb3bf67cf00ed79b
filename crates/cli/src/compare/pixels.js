"use strict";

// Numbers of the pictures: values behind codes, errors, colours. Nothing here knows the page.

const NOT_FINITE = 0x8000;
const BRIGHTEST = 0x7fff;

/** The value of every code; one that is not finite is NaN. */
function valuesOfCodes(lowest, stepsPerOctave) {
  const values = new Float64Array(65536);
  for (let magnitude = 1; magnitude <= BRIGHTEST; magnitude += 1) {
    values[magnitude] = 2 ** (lowest + magnitude / stepsPerOctave);
    values[magnitude | NOT_FINITE] = -values[magnitude];
  }
  values[NOT_FINITE] = NaN;
  return values;
}

/** Three codes per pixel, from the RGBA bytes of the two pictures that hold them. */
function joinBytes(high, low) {
  const codes = new Uint16Array(high.length / 4 * 3);
  for (let from = 0, to = 0; from < high.length; from += 4, to += 3) {
    codes[to] = high[from] << 8 | low[from];
    codes[to + 1] = high[from + 1] << 8 | low[from + 1];
    codes[to + 2] = high[from + 2] << 8 | low[from + 2];
  }
  return codes;
}

/** The sum of all codes, as the page's data has it. */
function sumOf(codes) {
  let sum = 0;
  for (const code of codes) sum = (sum + code) >>> 0;
  return sum;
}

/**
 * Logarithm to base 10 of every pixel's relative squared error, as the measure `rmse` takes it: what is not finite
 * counts as black. −∞ where there is no error, NaN where a pixel is not judged.
 */
function logErrors(codes, reference, judged, values, epsilon) {
  const counted = values.map((value) => value === value ? value : 0);
  const logs = new Float32Array(codes.length / 3);
  for (let pixel = 0; pixel < logs.length; pixel += 1) {
    let sum = 0;
    for (let at = pixel * 3; at < pixel * 3 + 3; at += 1) {
      const right = counted[reference[at]];
      const off = counted[codes[at]] - right;
      sum += off * off / (right * right + epsilon);
    }
    logs[pixel] = judged[pixel] ? Math.log10(sum / 3) : NaN;
  }
  return logs;
}

// Bins of the histogram: tenths of a decade from 1e-12 to 1e12; what lies outside is in the first or last one.
const FIRST_DECADE = -12;
const LAST_DECADE = 12;
const BINS_PER_DECADE = 10;

/** How many judged pixels have which error, and how many have none. */
function histogramOf(logs) {
  const bins = new Float64Array((LAST_DECADE - FIRST_DECADE) * BINS_PER_DECADE);
  let judged = 0;
  let equal = 0;
  for (const log of logs) {
    if (log !== log) continue;
    judged += 1;
    if (log === -Infinity) equal += 1;
    else {
      const bin = Math.floor((log - FIRST_DECADE) * BINS_PER_DECADE);
      bins[Math.min(Math.max(bin, 0), bins.length - 1)] += 1;
    }
  }
  return { bins, judged, equal };
}

/** The whole decades that all error maps are coloured between: of the errors, 5 % lie below and 0.5 % above. */
function commonDecades(histograms) {
  const bins = new Float64Array((LAST_DECADE - FIRST_DECADE) * BINS_PER_DECADE);
  for (const histogram of histograms) histogram.bins.forEach((count, bin) => { bins[bin] += count; });
  const total = bins.reduce((sum, count) => sum + count, 0);
  const quantile = (share) => {
    let sum = 0;
    const bin = bins.findIndex((count) => (sum += count) >= share * total);
    return FIRST_DECADE + bin / BINS_PER_DECADE;
  };
  if (total === 0) return [-6, 0];
  const last = Math.ceil(quantile(0.995) + 0.1);
  return [Math.min(Math.max(Math.floor(quantile(0.05)), last - 8), last - 2), last];
}

/** A linear value in 0 … 1 as an sRGB byte. */
function srgbByte(linear) {
  const light = Math.min(Math.max(linear, 0), 1);
  return Math.floor((light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055) * 255 + 0.5);
}

/** The byte that every code is shown by, lifted by `stops`. */
function bytesOfCodes(values, stops) {
  const factor = 2 ** stops;
  return Uint8Array.from(values, (value) => value === value ? srgbByte(value * factor) : 0);
}

// Eleven colours of matplotlib's inferno, which is even to the eye and to the colour-blind.
const INFERNO = [
  0x000004, 0x160b39, 0x420a68, 0x6a176e, 0x932667, 0xbc3754, 0xdd513a, 0xf37819, 0xfca50a, 0xf6d746, 0xfcffa4,
];
const NOT_JUDGED = 0x6e7b86;

/** 256 colours from dark to light, as pixels of a canvas (ABGR). */
function palette() {
  const colours = new Uint32Array(256);
  for (let i = 0; i < 256; i += 1) {
    const at = Math.min(i / 255 * 10, 9.999);
    const [from, to, share] = [INFERNO[Math.floor(at)], INFERNO[Math.floor(at) + 1], at - Math.floor(at)];
    const part = (shift) => Math.round((from >> shift & 255) * (1 - share) + (to >> shift & 255) * share);
    colours[i] = opaque(part(16), part(8), part(0));
  }
  return colours;
}

function opaque(red, green, blue) {
  return (255 << 24 | blue << 16 | green << 8 | red) >>> 0;
}

/** The colour of an error between the decades. */
function colourOfError(log, [first, last], colours) {
  if (log !== log) return opaque(NOT_JUDGED >> 16, NOT_JUDGED >> 8 & 255, NOT_JUDGED & 255);
  return colours[Math.round(Math.min(Math.max((log - first) / (last - first), 0), 1) * 255)];
}

/** The colour of a pixel, whose codes begin at `at`. */
function colourOfLight(codes, at, bytes) {
  return opaque(bytes[codes[at]], bytes[codes[at + 1]], bytes[codes[at + 2]]);
}
