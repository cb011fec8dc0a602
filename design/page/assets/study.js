// A study's designs: one quantity against another, parallel coordinates, and the section of the design pointed at.
"use strict";
(() => {
  const {designs, pictures} = updamp.data.study;
  const names = Object.keys(designs.columns), count = designs.numbers.length;
  const across = document.getElementById("study-x"), up = document.getElementById("study-y");
  const picture = document.getElementById("study-picture");
  const COLOURS = {best: "#D55E00", kept: "#0072B2", passed: "#8a8f98"};
  const GROUPS = [
    ["best", "best", i => designs.best[i]],
    ["kept", "other", i => !designs.best[i] && designs.kept[i]],
    ["passed", "passes a limit", i => !designs.best[i] && !designs.kept[i]],
  ];

  const places = chosen => [...Array(count).keys()].filter(chosen);

  function drawDesigns() {
    const x = designs.columns[across.value], y = designs.columns[up.value];
    const traces = GROUPS.map(([key, name, belongs]) => {
      const own = places(i => belongs(i) && x.values[i] !== null && y.values[i] !== null);
      if (key === "best") own.sort((a, b) => x.values[a] - x.values[b]);
      return {
        type: "scatter", mode: key === "best" && own.length > 1 ? "lines+markers" : "markers", name,
        x: own.map(i => x.values[i]), y: own.map(i => y.values[i]), customdata: own,
        text: own.map(i => `design ${designs.numbers[i]}`), hovertemplate: "%{text}<br>%{x:.5g}, %{y:.5g}<extra></extra>",
        marker: {color: COLOURS[key], size: key === "best" ? 9 : 7}, line: {color: COLOURS[key], width: 1, dash: "dot"},
      };
    }).filter(trace => trace.x.length > 0);
    updamp.draw("designs", traces, {
      xaxis: {title: {text: x.label}, type: x.log ? "log" : "linear"}, yaxis: {title: {text: y.label}, type: y.log ? "log" : "linear"},
    });
  }

  // Lines of plain SVG: plotly's own kind needs WebGL, and code made at run time, which the page's policy refuses.
  function drawParallel() {
    const axes = names.filter(name => new Set(designs.columns[name].values.filter(value => value !== null)).size > 1);
    const whole = places(i => axes.every(name => designs.columns[name].values[i] !== null));
    const scaled = axes.map(name => {
      const values = designs.columns[name].values.map(value => value !== null && designs.columns[name].log ? Math.log(value) : value);
      const known = whole.map(i => values[i]), low = Math.min(...known), high = Math.max(...known);
      return values.map(value => (value - low) / (high - low || 1));
    });
    const traces = GROUPS.map(([key, name, belongs]) => {
      const own = whole.filter(belongs);
      const column = make => own.flatMap(i => [...axes.map((_, axis) => make(i, axis)), null]);
      return {
        type: "scatter", mode: "lines+markers", name, connectgaps: false, customdata: column(i => i),
        x: column((_, axis) => axis), y: column((i, axis) => scaled[axis][i]),
        text: column((i, axis) => `design ${designs.numbers[i]}: ${updamp.digits(designs.columns[axes[axis]].values[i], 5)}`),
        hovertemplate: "%{text}<extra></extra>", opacity: key === "best" ? 1 : 0.45,
        marker: {color: COLOURS[key], size: 4}, line: {color: COLOURS[key], width: key === "best" ? 2.5 : 1},
      };
    }).filter(trace => trace.x.length > 0).reverse();
    const ends = axes.flatMap((name, axis) => [Math.min, Math.max].map((end, y) => ({
      x: axis, y, yshift: y ? 14 : -14, showarrow: false, font: {size: 11},
      text: updamp.digits(end(...whole.map(i => designs.columns[name].values[i])), 4),
    })));
    updamp.draw("parallel", traces, {
      annotations: whole.length ? ends : [], showlegend: traces.length > 1, legend: {orientation: "h", y: 1.25},
      xaxis: {tickvals: axes.map((_, axis) => axis), ticktext: axes.map(name => designs.columns[name].label), gridcolor: "#8a8f98", tickangle: 0},
      yaxis: {visible: false, range: [-0.15, 1.15]},
    });
  }

  function outline(points, colour) {
    return `<polygon points="${points.map(([x, y]) => `${x},${-y}`).join(" ")}" fill="${colour}" fill-opacity="0.35" stroke="${colour}" stroke-width="0.4"/>`;
  }

  function section(number) {
    const found = pictures[number] || pictures[""];
    if (!found) return "";
    const all = Object.values(found).flat(), xs = all.map(p => p[0]), ys = all.map(p => -p[1]);
    const [left, top] = [Math.min(...xs) - 2, Math.min(...ys) - 2];
    const box = [left, top, Math.max(...xs) + 2 - left, Math.max(...ys) + 2 - top].join(" ");
    const shapes = outline(found.left, COLOURS.passed) + outline(found.right, COLOURS.passed) + outline(found.damper, COLOURS.best);
    return `<svg viewBox="${box}" role="img" aria-label="Section of design ${number}">${shapes}</svg>`;
  }

  function show(i) {
    const rows = names.map(name => {
      const {label, values} = designs.columns[name];
      return `<dt>${label}</dt><dd>${values[i] === null ? "not known" : updamp.digits(values[i], 5)}</dd>`;
    });
    picture.innerHTML = `<strong>Design ${designs.numbers[i]}</strong>${section(designs.numbers[i])}<dl>${rows.join("")}</dl>`;
  }

  updamp.whenReady(() => {
    for (const list of [across, up]) {
      for (const name of names) list.add(new Option(designs.columns[name].label, name));
    }
    [across.value, up.value] = designs.first;
    for (const list of [across, up]) list.addEventListener("change", drawDesigns);
    drawDesigns();
    drawParallel();
    for (const name of ["designs", "parallel"]) {
      updamp.plot(name).on("plotly_hover", event => show(event.points[0].customdata));
    }
    if (count > 0) show(Math.max(designs.best.indexOf(true), 0));
  });
})();
