// Common to all sections: the page's data, the look of the plots, drawing, printing.
"use strict";
const updamp = (() => {
  const page = JSON.parse(document.getElementById("report-data").textContent);
  const INK = "#1a1a1a", GRID = "#e3e6ea", PRINT_WIDTH = 690; // px: A4 between its margins
  const BASE = {
    font: {family: "system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif", size: 13, color: INK},
    paper_bgcolor: "#ffffff", plot_bgcolor: "#ffffff", hovermode: "closest", autosize: true,
    margin: {l: 70, r: 20, t: 44, b: 50},
    legend: {bgcolor: "rgba(255,255,255,0.85)", font: {size: 12}},
    hoverlabel: {bgcolor: "#ffffff", bordercolor: "#8a8f98", font: {color: INK}},
  };
  const AXIS = {gridcolor: GRID, linecolor: "#8a8f98", showline: true, ticks: "outside", tickcolor: "#8a8f98", zeroline: false};
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
    data: page.sections, palette: page.palette, draw, plot, start,
    whenReady: starter => starters.push(starter),
    unique: values => [...new Set(values)],
    digits: (value, count) => String(Number(value.toPrecision(count))),
    levelName: level => `${Number(level.toPrecision(4))} ${page.level.unit}`, levelUnit: page.level.unit, levelWord: page.level.word,
  };
})();
