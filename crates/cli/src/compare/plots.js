
// Tables and the histogram.

/** A new element with text and children; texts are never read as HTML. */
function element(name, text = "", children = []) {
  const made = document.createElement(name);
  made.textContent = text;
  made.append(...children);
  return made;
}

/** Fills a table: names of the columns, then rows of a name and cells, each a text or an element. */
function fillTable(table, head, rows) {
  const cell = (kind, content) => element(kind, "", [content]);
  table.replaceChildren(
    element("thead", "", [element("tr", "", head.map((name) => cell("th", name)))]),
    element("tbody", "", rows.map(([name, ...cells]) =>
      element("tr", "", [cell("th", name), ...cells.map((content) => cell("td", content))]))),
  );
}

/** 10 to a whole power. */
function power(exponent) {
  return "10" + [...String(exponent)].map((sign) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[sign] ?? "⁻").join("");
}

/** A new element of the drawing `svg`. */
function shape(svg, name, attributes, text = "") {
  const made = document.createElementNS(svg.namespaceURI, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

/** Colour and dashes of line `i`: eight colours, then again with dashes. */
function lineStyle(i) {
  return { style: `stroke: var(--line-${i % 8})`, "stroke-dasharray": ["none", "6 3", "2 3"][Math.floor(i / 8) % 3] };
}

const binEdge = (bin) => bin / BINS_PER_DECADE + FIRST_DECADE;
const shareIn = ({ bins, judged }, bin) => bins[bin] / Math.max(judged, 1);

/** The whole decades in which anybody has a share of the pixels that can be seen. */
function drawnDecades(histograms) {
  const seen = histograms.flatMap((h) => [...h.bins.keys()].filter((bin) => shareIn(h, bin) > 0.0002));
  if (seen.length === 0) return [-6, 0];
  return [Math.floor(binEdge(Math.min(...seen))), Math.ceil(binEdge(Math.max(...seen) + 1))];
}

/** Draws a line for each histogram into `svg`. */
function drawHistogram(svg, histograms) {
  const [width, height, left, bottom, top] = [760, 280, 48, 26, 10];
  const [first, last] = drawnDecades(histograms);
  const highest = Math.max(0.01, ...histograms.flatMap((h) => [...h.bins.keys()].map((bin) => shareIn(h, bin))));
  const x = (log) => left + (log - first) / (last - first) * (width - left - 10);
  const y = (part) => height - bottom - part / highest * (height - bottom - top);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const parts = [];
  for (let log = first; log <= last; log += last - first > 12 ? 2 : 1) {
    parts.push(shape(svg, "line", { class: "axis", x1: x(log), x2: x(log), y1: top, y2: height - bottom }));
    parts.push(shape(svg, "text", { x: x(log), y: height - 8, "text-anchor": "middle" }, power(log)));
  }
  for (const part of [0, highest / 2, highest]) {
    parts.push(shape(svg, "line", { class: "axis", x1: left, x2: width - 10, y1: y(part), y2: y(part) }));
    const percent = `${(part * 100).toFixed(1)} %`;
    parts.push(shape(svg, "text", { x: left - 6, y: y(part) + 4, "text-anchor": "end" }, percent));
  }
  histograms.forEach((histogram, i) => {
    const points = [];
    for (let bin = (first - FIRST_DECADE) * BINS_PER_DECADE; binEdge(bin) < last - 1e-9; bin += 1) {
      points.push(`${x(binEdge(bin + 0.5)).toFixed(1)} ${y(shareIn(histogram, bin)).toFixed(1)}`);
    }
    parts.push(shape(svg, "path", { d: `M${points.join("L")}`, ...lineStyle(i) }));
  });
  svg.replaceChildren(...parts);
}

/** Says which line is whose, and what it leaves out: errors beyond the plot, and pixels without any. */
function listLines(list, svg, names, histograms) {
  const [first, last] = drawnDecades(histograms).map((log) => (log - FIRST_DECADE) * BINS_PER_DECADE);
  list.replaceChildren(...histograms.map((histogram, i) => {
    const drawing = shape(svg, "svg", { viewBox: "0 0 32 12" });
    drawing.append(shape(svg, "path", { d: "M0 6H32", ...lineStyle(i) }));
    const { bins, judged, equal } = histogram;
    const sum = (from, to) => bins.slice(from, to).reduce((all, count) => all + count, 0);
    const left = [["without error", equal], ["below", sum(0, first)], ["above", sum(last)]]
      .filter(([, count]) => count > 0)
      .map(([where, count]) => `${Number((count / judged * 100).toPrecision(2))} % ${where}`);
    return element("li", "", [drawing, names[i] + (left.length > 0 ? ` (not drawn: ${left.join(", ")})` : "")]);
  }));
}
