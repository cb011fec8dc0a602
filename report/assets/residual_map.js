// Heat map of the residual's size, one panel a mode; a click selects the curve and marks the frequency.
"use strict";
(() => {
  const {selection} = updamp;
  const {maps, scale, worst} = updamp.data.misfit;
  const GAP = 0.12; // of the width, between panels
  const axis = (letter, i) => letter + (i === 0 ? "" : i + 1);
  const sweepOf = up => (up ? "up" : "down");
  const round = value => updamp.digits(value, 2).replace("-", "−");

  // The scale ends at a power of two that few cells exceed: 32 at least; up to 2 times the scatter its colours stay.
  const sizes = maps.flatMap(map => map.cells.flat()).filter(cell => cell !== null).map(cell => cell.size).sort((a, b) => a - b);
  const TOP = Math.max(5, Math.ceil(Math.log2(sizes[Math.floor(0.98 * (sizes.length - 1))] || 1)));
  const FIXED = 2 / (TOP + 1), FIXED_AS_GIVEN = 1 / 3; // where 2 times the scatter lies on the scale
  const stretched = scale.map(([place, colour]) => [place <= FIXED_AS_GIVEN ? place / FIXED_AS_GIVEN * FIXED
    : FIXED + (place - FIXED_AS_GIVEN) / (1 - FIXED_AS_GIVEN) * (1 - FIXED), colour]);
  const STEP = TOP > 8 ? 2 : 1;
  const TICKS = [-1, 0, ...Array.from({length: TOP}, (_, k) => k + 1).filter(power => (TOP - power) % STEP === 0)];

  const textOf = cell => cell === null ? "" : `${round(cell.size)} times the scatter<br>worst at ${cell.channel}, `
    + `${updamp.digits(cell.f, 6)} Hz<br>amplitude ${round(cell.amplitude)}, phase ${round(cell.phase)} `
    + `standard deviations<br>${cell.n} values`;

  function trace(map, i) {
    return {
      type: "heatmap", x: map.edges, y: map.rows, xaxis: axis("x", i), yaxis: axis("y", i), coloraxis: "coloraxis",
      z: map.cells.map(row => row.map(cell => (cell === null ? null : Math.log2(Math.max(cell.size, 0.25))))),
      text: map.cells.map(row => row.map(textOf)), hoverongaps: false, xgap: 1, ygap: 2,
      hovertemplate: `${map.mode}, %{y}<br>%{text}<extra></extra>`,
    };
  }

  // A frame about the row on show, and about the marked cell.
  function frames() {
    const {mode, level, sweep, frequency} = selection.state;
    return maps.flatMap((map, i) => map.mode !== mode ? [] : map.levels.flatMap((rowLevel, row) => {
      const isShown = (level === selection.ALL || level === rowLevel) && (sweep === selection.BOTH || sweep === sweepOf(map.up[row]));
      const frame = (x0, x1, width) => ({type: "rect", xref: axis("x", i), yref: axis("y", i), x0, x1, y0: row - 0.48,
        y1: row + 0.48, line: {color: "#1a1a1a", width}});
      const column = frequency === null ? -1 : map.edges.findIndex((edge, k) => edge <= frequency && frequency <= map.edges[k + 1]);
      return !isShown ? [] : [frame(map.edges[0], map.edges.at(-1), 1.2),
        ...(column >= 0 ? [frame(map.edges[column], map.edges[column + 1], 3)] : [])];
    }));
  }

  function layout() {
    const width = (1 - GAP * (maps.length - 1)) / maps.length;
    const result = {
      shapes: frames(), margin: {t: 44, l: 90, b: 50}, annotations: [],
      coloraxis: {colorscale: stretched, cmin: -1, cmax: TOP, colorbar: {title: {text: "times<br>the scatter"}, thickness: 14,
        tickvals: TICKS, ticktext: TICKS.map(power => (power < 0 ? "½" : String(2 ** power)))}},
    };
    maps.forEach((map, i) => {
      const from = i * (width + GAP);
      result[axis("xaxis", i)] = {domain: [from, from + width], anchor: axis("y", i), title: {text: "frequency [Hz]"}, showgrid: false};
      result[axis("yaxis", i)] = {anchor: axis("x", i), type: "category", showgrid: false, automargin: true, ticks: ""};
      result.annotations.push({text: `<b>${map.mode}</b>`, x: from, y: 1, xref: "paper", yref: "paper", xanchor: "left",
        yanchor: "bottom", showarrow: false, font: {size: 14}});
    });
    return result;
  }

  function choose(map, row, cell) {
    selection.select({mode: map.mode, level: map.levels[row], channel: cell.channel, sweep: sweepOf(map.up[row]), frequency: cell.f});
    const isCalm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    updamp.plot("response").closest("section").scrollIntoView({behavior: isCalm ? "auto" : "smooth", block: "start"});
  }

  function listWorst() {
    const bySize = (a, b) => b.cell.size - a.cell.size;
    const rows = maps.flatMap(map => map.cells.map((row, r) => row.filter(cell => cell !== null).map(cell => ({map, r, cell}))));
    const largest = rows.map(row => row.sort(bySize)[0]).sort(bySize).slice(0, worst);
    document.getElementById("worst-places").replaceChildren(...largest.map(({map, r, cell}) => {
      const button = document.createElement("button");
      const factor = document.createElement("strong");
      button.type = "button";
      factor.textContent = `${round(cell.size)}×`;
      button.append(factor, ` ${map.mode}, ${map.rows[r]}, ${updamp.digits(cell.f, 5)} Hz, ${cell.channel}`);
      button.addEventListener("click", () => choose(map, r, cell));
      return button;
    }));
  }

  updamp.whenReady(() => {
    listWorst();
    updamp.draw("residual-map", maps.map(trace), layout());
    updamp.plot("residual-map").on("plotly_click", event => {
      const point = event.points[0];
      const [row, column] = point.pointNumber;
      const map = maps[point.curveNumber];
      if (map.cells[row][column] !== null) choose(map, row, map.cells[row][column]);
    });
  });
  selection.onChange(() => updamp.draw("residual-map", maps.map(trace), layout()));
})();
