// Common to all sections: the page's data, the look of the plots, drawing, printing.
"use strict";
const updamp = (() => {
  const page = JSON.parse(document.getElementById("report-data").textContent);
  const INK = "#1a1a1a", GRID = "#e3e6ea", PRINT_WIDTH = 862; // px: A4 between its margins, over the zoom in report.css
  const BASE = {
    font: {family: "system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif", size: 13, color: INK},
    paper_bgcolor: "#ffffff", plot_bgcolor: "#ffffff", hovermode: "closest", autosize: true,
    margin: {l: 70, r: 20, t: 44, b: 50},
    legend: {bgcolor: "rgba(255,255,255,0.85)", font: {size: 12}},
    hoverlabel: {bgcolor: "#ffffff", bordercolor: "#8a8f98", font: {color: INK}},
  };
  const AXIS = {automargin: true, title: {font: {size: 14}}, gridcolor: GRID, linecolor: "#8a8f98", showline: true, ticks: "outside", tickcolor: "#8a8f98", zeroline: false};
  const CONFIG = {
    responsive: true, displaylogo: false, showTips: false,
    showSendToCloud: false, plotlyServerURL: "", // the data stay where they are
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    toImageButtonOptions: {format: "svg"},
  };
  const starters = [];

  const isTable = value => value !== null && typeof value === "object" && !Array.isArray(value);

  function merged(base, own) {
    const result = {...base};
    for (const [key, value] of Object.entries(own)) {
      result[key] = isTable(value) && isTable(base[key]) ? merged(base[key], value) : value;
    }
    return result;
  }

  function layoutOf(own) {
    const layout = merged(BASE, own);
    for (const axis of ["xaxis", "yaxis", ...Object.keys(layout).filter(key => /^[xy]axis\d+$/.test(key))]) {
      layout[axis] = merged(AXIS, layout[axis] || {});
    }
    return layout;
  }

  // Ticks of a logarithmic axis: 1, 2 and 5 of each decade, or fewer, so that `room` of them at most are labelled; plotly's
  // own labels overlap on narrow axes. The ends are the values' own.
  function logAxis(values, room) {
    const known = values.filter(value => value > 0);
    if (known.length === 0) return {type: "log"};
    const ends = [Math.log10(Math.min(...known)), Math.log10(Math.max(...known))];
    const padding = Math.max(0.06 * (ends[1] - ends[0]), 0.03), range = [ends[0] - padding, ends[1] + padding];
    const ticks = steps => {
      const found = [];
      for (let decade = Math.floor(range[0]); decade <= range[1]; decade++) found.push(...steps.map(step => step * 10 ** decade));
      return found.filter(tick => Math.log10(tick) >= range[0] && Math.log10(tick) <= range[1]);
    };
    const FINEST_FIRST = [[1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 5, 6, 7, 8, 9], [1, 1.5, 2, 3, 4, 5, 7], [1, 2, 3, 5], [1, 2, 5], [1, 3], [1]];
    const tickvals = FINEST_FIRST.map(ticks).find(each => each.length <= room) || ticks([1]).filter((_, i) => i % 2 === 0);
    return {type: "log", range, tickmode: "array", tickangle: 0, tickvals, ticktext: tickvals.map(tick => String(Number(tick.toPrecision(2))))};
  }

  const plot = name => document.getElementById(`plot-${name}`);

  function draw(name, traces, layout) {
    return Plotly.react(plot(name), traces, layoutOf(layout), CONFIG);
  }

  function allPlots() {
    return [...document.querySelectorAll(".js-plotly-plot")];
  }

  function start() {
    for (const [name, figure] of Object.entries(page.figures)) draw(name, figure.data, figure.layout);
    for (const starter of starters) starter();
    const folded = [...document.querySelectorAll("details:not([open])")];
    window.addEventListener("beforeprint", () => {
      folded.forEach(details => { details.dataset.folded = String(!details.open); details.open = true; });
      allPlots().forEach(each => Plotly.relayout(each, {width: PRINT_WIDTH, autosize: false}));
    });
    window.addEventListener("afterprint", () => {
      folded.forEach(details => { details.open = details.dataset.folded !== "true"; });
      allPlots().forEach(each => Plotly.relayout(each, {width: null, autosize: true}));
    });
    document.body.dataset.ready = "yes";
  }

  return {
    data: page.sections, palette: page.palette, draw, plot, start, logAxis,
    whenReady: starter => starters.push(starter),
    unique: values => [...new Set(values)],
    digits: (value, count) => String(Number(value.toPrecision(count))),
    levelName: level => `${Number(level.toPrecision(3))} ${page.level.unit}`, levelUnit: page.level.unit, levelWord: page.level.word,
    units: page.units,
  };
})();
