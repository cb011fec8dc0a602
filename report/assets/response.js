// Frequency response: measured repeats with their band, model before and after, amplitude over phase.
"use strict";
(() => {
  const {selection, palette} = updamp;
  const {curves} = updamp.data.response;
  const option = id => document.getElementById(id).checked;

  // A value of "a" (amplitude) or "p" (phase) goes to the upper or lower axes.
  const PARTS = [{key: "a", axis: "y", unit: updamp.units.receptance, format: ".4g"}, {key: "p", axis: "y2", unit: "°", format: ".1f"}];

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
    const both = selection.state.sweep === selection.BOTH;
    const direction = curve.up ? "up" : "down";
    return curve.measured.flatMap(({repeat, ...values}, k) => PARTS.map(({key, axis, unit, format}) => ({
      type: "scatter", mode: "markers", x: values.f, y: values[key], yaxis: axis,
      name: `measured, ${both ? `${direction}wards` : `repeat ${repeat}`}`,
      legendgroup: `measured ${both ? direction : repeat}`, showlegend: named && key === "a" && (!both || k === 0),
      marker: {color: colour, size: 6, line: {width: 1.4},
        symbol: both ? `triangle-${direction}-open` : selection.symbolOf(repeat)},
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

  // Both sweeps of a level see one branch: what either visits is drawn solid, once.
  function branchesOf(group, which) {
    const [first, ...others] = group.map(curve => curve[which]);
    if (others.some(branch => branch.f.length !== first.f.length)) return [first, ...others];
    return [{...first, visited: first.visited.map((seen, i) => (others.some(branch => branch.visited[i]) ? 1 : seen))}];
  }

  function tracesOf(shown) {
    const several = selection.state.level === selection.ALL;
    return updamp.unique(shown.map(curve => curve.level)).flatMap(level => {
      const group = shown.filter(curve => curve.level === level);
      const colour = several ? selection.colourOf(level) : null;
      const after = branchesOf(group, "after").flatMap(branch => modelTraces(branch, several ? updamp.levelName(level) : "calibrated model",
        {color: colour || palette.after, width: 2}, `after ${level}`));
      const before = !option("show-before") ? [] : branchesOf(group, "before").flatMap(branch => modelTraces(branch,
        "before calibration", {color: colour || palette.before, width: 1.3, dash: "dash"}, "before"));
      if (several) before.forEach(trace => { trace.showlegend = false; trace.opacity = 0.6; });
      return [...group.map((curve, k) => bandTrace(curve, k === 0 && !several)), ...before, ...after,
        ...group.flatMap(curve => measuredTraces(curve, colour || palette.measured, !several))];
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

  // Whole quarters of a turn, with some room.
  function phaseRange(traces) {
    const all = traces.filter(trace => trace.yaxis === "y2").flatMap(trace => trace.y).filter(value => value !== null);
    return all.length === 0 ? undefined
      : [90 * Math.floor(Math.min(...all) / 90 + 0.05) - 10, 90 * Math.ceil(Math.max(...all) / 90 - 0.05) + 10];
  }

  function draw() {
    const shown = selection.chosen(curves);
    const {frequency} = selection.state;
    const log = option("logarithmic");
    const mark = frequency === null ? [] : [{type: "line", xref: "x", yref: "paper", x0: frequency, x1: frequency, y0: 0,
      y1: 1, line: {color: "#6b1d00", width: 1.5, dash: "dashdot"}}];
    const traces = tracesOf(shown);
    updamp.draw("response", traces, {
      xaxis: {title: {text: "frequency [Hz]"}, range: rangeOf(shown), anchor: "y2"},
      yaxis: {title: {text: `receptance [${updamp.units.receptance}]`}, domain: [0.36, 1], type: log ? "log" : "linear",
        rangemode: log ? "normal" : "tozero", tickformat: "~g",
        ...(log ? {dtick: "D2"} : {})},
      yaxis2: {title: {text: "phase [°]"}, domain: [0, 0.29], tick0: 0, dtick: 90, range: phaseRange(traces)},
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
