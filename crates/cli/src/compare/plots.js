
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

/** Draws a line for each histogram into `svg`. */
function drawHistogram(svg, histograms) {
  const [width, height, left, bottom, top] = [760, 280, 48, 26, 10];
  const used = histograms.flatMap(({ bins }) => [bins.findIndex((n) => n > 0), bins.findLastIndex((n) => n > 0)]);
  const bins = used.filter((bin) => bin >= 0);
  const decade = (bin) => bin / BINS_PER_DECADE + FIRST_DECADE;
  const first = Math.floor(decade(Math.min(...bins, 60)));
  const last = Math.ceil(decade(Math.max(...bins, 119) + 1));
  const share = ({ bins, judged }, bin) => bins[bin] / Math.max(judged, 1);
  const highest = Math.max(0.01, ...histograms.flatMap((h) => [...h.bins.keys()].map((bin) => share(h, bin))));
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
    for (let bin = (first - FIRST_DECADE) * BINS_PER_DECADE; decade(bin) < last; bin += 1) {
      points.push(`${x(decade(bin + 0.5)).toFixed(1)} ${y(share(histogram, bin)).toFixed(1)}`);
    }
    parts.push(shape(svg, "path", { d: `M${points.join("L")}`, ...lineStyle(i) }));
  });
  svg.replaceChildren(...parts);
}

/** Says which line is whose. */
function listLines(list, svg, names, histograms) {
  list.replaceChildren(...histograms.map(({ judged, equal }, i) => {
    const drawing = shape(svg, "svg", { viewBox: "0 0 32 12" });
    drawing.append(shape(svg, "path", { d: "M0 6H32", ...lineStyle(i) }));
    const without = equal > 0 ? ` (${(equal / judged * 100).toFixed(1)} % without error, not drawn)` : "";
    return element("li", "", [drawing, names[i] + without]);
  }));
}
