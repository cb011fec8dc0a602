// Residual of amplitude and phase against the displacement, all force levels of the chosen mode, channel and sweep.
"use strict";
(() => {
  const {selection} = updamp;
  const {points} = updamp.data.amplitude;
  const PARTS = [["amplitude", "y", true], ["phase", "y2", false]];

  function draw() {
    const shown = selection.chosen(points, {anyLevel: true});
    const levels = new Set();
    const traces = shown.flatMap(({level, up, x, f, ...parts}) => PARTS.map(([part, axis, isFirst]) => {
      const showlegend = isFirst && !levels.has(level);
      if (isFirst) levels.add(level);
      const isSelected = selection.state.level === selection.ALL || selection.state.level === level;
      return {
        type: "scatter", mode: "markers", x, y: parts[part], xaxis: axis.replace("y", "x"), yaxis: axis, customdata: f,
        name: updamp.levelName(level), legendgroup: `${level}`, showlegend, opacity: isSelected ? 1 : 0.35,
        marker: {color: selection.colourOf(level), size: 6, symbol: up ? "circle" : "triangle-down"},
        hovertemplate: `${updamp.levelName(level)}, %{customdata:.2f} Hz<br>%{x:.3g} ${updamp.units.displacement}: %{y:.1f} standard deviations<extra></extra>`,
      };
    }));
    const strip = axis => ({type: "rect", layer: "below", xref: `${axis.replace("y", "x")} domain`, yref: axis, x0: 0, x1: 1,
      y0: -1.96, y1: 1.96, fillcolor: "#e3e6ea", line: {width: 0}});
    const across = (domain, anchor) => ({...updamp.logAxis(shown.flatMap(each => each.x), 9),
      title: {text: `displacement amplitude [${updamp.units.displacement}]`}, domain, anchor});
    updamp.draw("residual-amplitude", traces, {
      xaxis: across([0, 0.44], "y"), xaxis2: across([0.56, 1], "y2"),
      yaxis: {title: {text: "amplitude residual [σ]"}, zeroline: true, zerolinecolor: "#8a8f98"},
      yaxis2: {title: {text: "phase residual [σ]"}, anchor: "x2", zeroline: true, zerolinecolor: "#8a8f98"},
      shapes: ["y", "y2"].map(strip), margin: {r: 110}, legend: {title: {text: updamp.levelWord}},
    });
  }

  selection.onChange(draw);
})();
