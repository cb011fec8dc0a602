// Resonance frequency and loss factor against amplitude, peak receptance against force.
"use strict";
(() => {
  const {selection, palette} = updamp;
  const {measured, model} = updamp.data.backbones;
  const PANELS = [
    {x: "amplitude", y: "frequency", across: `displacement amplitude [${updamp.units.displacement}]`, up: "resonance frequency [Hz]"},
    {x: "amplitude", y: "damping", across: `displacement amplitude [${updamp.units.displacement}]`, up: "loss factor [–]"},
    {x: "level", y: "receptance", across: `${updamp.levelWord === "force level" ? "force" : updamp.levelWord} [${updamp.levelUnit}]`, up: `peak receptance [${updamp.units.receptance}]`},
  ];
  const WIDTH = 0.25; // of all; between them are the labels of the next
  const axis = (letter, i) => letter + (i === 0 ? "" : i + 1);

  const pick = (values, keep) => values.filter((_, k) => keep[k]);

  function measuredTraces(backbone, panel, i) {
    return updamp.unique(backbone.repeat).map(repeat => {
      const keep = backbone.repeat.map(each => each === repeat);
      return {
        type: "scatter", mode: "markers", x: pick(backbone[panel.x], keep), y: pick(backbone[panel.y], keep),
        customdata: pick(backbone.level, keep), name: `measured, repeat ${repeat}`, legendgroup: `${repeat}`,
        showlegend: i === 0, xaxis: axis("x", i), yaxis: axis("y", i),
        marker: {color: palette.measured, size: 8, symbol: selection.symbolOf(repeat), line: {width: 1.5}},
        hovertemplate: `repeat ${repeat}, %{customdata:.4g} ${updamp.levelUnit}<br>%{x:.4g}: %{y:.5g}<extra></extra>`,
      };
    });
  }

  function modelTrace(backbone, panel, i) {
    return {
      type: "scatter", mode: backbone.level.length > 1 ? "lines+markers" : "markers", x: backbone[panel.x], y: backbone[panel.y],
      customdata: backbone.level, name: "calibrated model", legendgroup: "model", showlegend: i === 0,
      xaxis: axis("x", i), yaxis: axis("y", i), line: {color: palette.after, width: 2}, marker: {color: palette.after, size: 4},
      hovertemplate: `model, %{customdata:.4g} ${updamp.levelUnit}<br>%{x:.4g}: %{y:.5g}<extra></extra>`,
    };
  }

  function draw() {
    const lines = selection.chosen(model, {anyLevel: true}), points = selection.chosen(measured, {anyLevel: true});
    const traces = PANELS.flatMap((panel, i) => [
      ...lines.map(each => modelTrace(each, panel, i)), ...points.flatMap(each => measuredTraces(each, panel, i))]);
    const layout = {margin: {t: 60}, legend: {orientation: "h", x: 0, y: 1.02, yanchor: "bottom"}};
    PANELS.forEach((panel, i) => {
      const from = i * (1 - WIDTH) / (PANELS.length - 1);
      layout[axis("xaxis", i)] = {...updamp.logAxis([...lines, ...points].flatMap(each => each[panel.x]), 6),
        title: {text: panel.across}, domain: [from, from + WIDTH], anchor: axis("y", i)};
      layout[axis("yaxis", i)] = {title: {text: panel.up, standoff: 12}, anchor: axis("x", i), tickformat: i === 0 ? "" : "~g"};
    });
    updamp.draw("backbones", traces, layout);
  }

  selection.onChange(draw);
})();
