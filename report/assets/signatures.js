// Signature of the chosen effect over the residual of the curves on show.
"use strict";
(() => {
  const {selection, palette} = updamp;
  const {signatures} = updamp.data.signatures;
  const effects = updamp.unique(signatures.map(each => each.effect));
  const PARTS = [["amplitude", ""], ["phase", "2"]];
  const chooser = document.getElementById("select-effect");

  function draw() {
    const several = selection.state.level === selection.ALL;
    const effect = effects[Number(chooser.value)];
    const shown = selection.chosen(signatures.filter(each => each.effect === effect));
    const traces = shown.flatMap((each, k) => PARTS.flatMap(([part, axis]) => {
      const colour = several ? selection.colourOf(each.level) : null;
      const common = {type: "scatter", x: each.f, xaxis: `x${axis}`, yaxis: `y${axis}`};
      const hover = `${updamp.levelName(each.level)}, %{x:.2f} Hz: %{y:.1f} σ<extra></extra>`;
      return [
        {...common, mode: "markers", y: each.residual[part], name: several ? updamp.levelName(each.level) : "residual",
          legendgroup: `residual ${each.level}`, showlegend: part === "amplitude" && (several || k === 0),
          marker: {color: colour || palette.measured, size: 6, symbol: "circle-open"}, hovertemplate: hover},
        {...common, mode: "lines", y: each[part], name: effect, legendgroup: "effect",
          showlegend: part === "amplitude" && k === 0, line: {color: colour || palette.after, width: 2}, hovertemplate: hover},
      ];
    }));
    const across = (domain, anchor) => ({title: {text: "frequency [Hz]"}, domain, anchor});
    const up = (part, anchor) => ({title: {text: `${part} [σ]`}, anchor, zeroline: true, zerolinecolor: "#8a8f98"});
    updamp.draw("signatures", traces, {
      xaxis: across([0, 0.45], "y"), xaxis2: across([0.55, 1], "y2"), yaxis: up("amplitude", "x"), yaxis2: up("phase", "x2"),
      margin: {t: 64}, legend: {orientation: "h", x: 0, y: 1.02, yanchor: "bottom"},
    });
  }

  chooser.replaceChildren(...effects.map((effect, i) => new Option(effect, i)));
  chooser.addEventListener("change", draw);
  selection.onChange(draw);
})();
