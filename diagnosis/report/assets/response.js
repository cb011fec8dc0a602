// Frequency response: measured repeats with their band, model before and after, amplitude over phase.
"use strict";
(() => {
  const {selection, palette} = updamp;
  const {curves} = updamp.data.response;
  const option = id => document.getElementById(id).checked;

  // A value of "a" (amplitude) or "p" (phase) goes to the upper or lower axes.
  const PARTS = [{key: "a", axis: "y", unit: "mm/N", format: ".4g"}, {key: "p", axis: "y2", unit: "°", format: ".1f"}];

  function line(branch, key, keep) {
    return branch[key].map((value, i) => (keep(branch.visited, i) ? value : null));
  }
  const isVisited = (visited, i) => visited[i] === 1;
  const isJumpedOver = (visited, i) => visited[i] === 0 || visited[i - 1] === 0 || visited[i + 1] === 0;

  function modelTraces(branch, name, style, group) {
    const common = {type: "scatter", mode: "lines", x: branch.f, legendgroup: group, name, connectgaps: false};
    const traces = [];
    for (const {key, axis, unit, format} of PARTS) {
      const hover = `${name}<br>%{x:.2f} Hz: %{y:${format}} ${unit}<extra></extra>`;
      traces.push({...common, y: line(branch, key, isVisited), yaxis: axis, line: style, hovertemplate: hover,
        showlegend: key === "a"});
      if (branch.visited.includes(0)) {
        traces.push({...common, y: line(branch, key, isJumpedOver), yaxis: axis, showlegend: false,
          line: {...style, dash: "dot"}, hovertemplate: hover.replace("<extra>", "<br>jumped over<extra>")});
      }
    }
    return traces;
  }

  function measuredTraces(curve, colour, named) {
    return curve.measured.flatMap(({repeat, ...values}) => PARTS.map(({key, axis, unit, format}) => ({
      type: "scatter", mode: "markers", x: values.f, y: values[key], yaxis: axis,
      name: `measured, repeat ${repeat}`, legendgroup: `measured ${repeat}`, showlegend: named && key === "a",
      marker: {color: colour, size: 6, line: {width: 1.4},
        symbol: selection.state.sweep === selection.BOTH ? `triangle-${curve.up ? "up" : "down"}-open`
          : selection.symbolOf(repeat)},
      hovertemplate: `${curve.run}, repeat ${repeat}<br>%{x:.2f} Hz: %{y:${format}} ${unit}<extra></extra>`,
    })));
  }

  function bandTrace(curve, named) {
    const {f, lower, upper} = curve.band;
    return {
      type: "scatter", mode: "lines", fill: "toself", fillcolor: palette.band, line: {width: 0}, hoverinfo: "skip",
      x: [...f, ...[...f].reverse()], y: [...upper, ...[...lower].reverse()], yaxis: "y",
      name: "95 % of repeats", legendgroup: "band", showlegend: named,
    };
  }

  function tracesOf(shown) {
    const several = selection.state.level === selection.ALL;
    const seen = new Set();
    return shown.flatMap(curve => {
      const colour = several ? selection.colourOf(curve.level) : null;
      const isFirst = !seen.has(several ? curve.level : "one");
      seen.add(several ? curve.level : "one");
      const after = modelTraces(curve.after, several ? `${curve.level} N` : "calibrated model",
        {color: colour || palette.after, width: 2}, several ? `level ${curve.level}` : "after");
      const before = option("show-before") ? modelTraces(curve.before, "before calibration",
        {color: colour || palette.before, width: 1.2, dash: "dash"}, "before") : [];
      if (several) before.forEach(trace => { trace.showlegend = false; trace.opacity = 0.6; });
      const measured = measuredTraces(curve, colour || palette.measured, isFirst && !several);
      if (!isFirst) [...after, ...before].forEach(trace => { trace.showlegend = false; });
      return [bandTrace(curve, isFirst && !several), ...before, ...after, ...measured];
    });
  }

  // The measured frequencies and the model's peaks, with some room.
  function rangeOf(shown) {
    const peak = branch => branch.f[branch.a.indexOf(Math.max(...branch.a))];
    const branches = curve => (option("show-before") ? [curve.before, curve.after] : [curve.after]);
    const all = shown.flatMap(curve => [
      ...curve.measured.flatMap(each => each.f), ...branches(curve).filter(b => b.f.length > 0).map(peak)]);
    const low = Math.min(...all), high = Math.max(...all), room = 0.04 * (high - low) || 1;
    return [low - room, high + room];
  }

  function draw() {
    const shown = selection.chosen(curves);
    const {frequency} = selection.state;
    const log = option("logarithmic");
    const mark = frequency === null ? [] : [{type: "line", xref: "x", yref: "paper", x0: frequency, x1: frequency, y0: 0,
      y1: 1, line: {color: "#6b1d00", width: 1.5, dash: "dashdot"}}];
    updamp.draw("response", tracesOf(shown), {
      xaxis: {title: {text: "frequency [Hz]"}, range: rangeOf(shown), anchor: "y2"},
      yaxis: {title: {text: "receptance [mm/N]"}, domain: [0.36, 1], type: log ? "log" : "linear",
        rangemode: log ? "normal" : "tozero", exponentformat: "power"},
      yaxis2: {title: {text: "phase [°]"}, domain: [0, 0.29], tick0: 0, dtick: 90},
      shapes: mark,
      annotations: mark.map(each => ({x: each.x0, y: 1, xref: "x", yref: "paper", yanchor: "bottom", showarrow: false,
        text: `${updamp.digits(frequency, 6)} Hz`, font: {color: "#6b1d00", size: 12}})),
      margin: {t: 44, r: 190}, legend: {x: 1.01, y: 1, xanchor: "left",
        title: {text: selection.state.level === selection.ALL ? "calibrated, at" : ""}},
    });
  }

  selection.onChange(draw);
  for (const id of ["logarithmic", "show-before"]) document.getElementById(id).addEventListener("change", draw);
})();
