// What is looked at: mode, force level (or all), channel, sweep direction (or both), and a marked frequency.
"use strict";
updamp.selection = (() => {
  const ALL = "all", BOTH = "both";
  const {curves, start} = updamp.data.response || {curves: [], start: 0};
  const sweepOf = curve => (curve.up ? "up" : "down");
  const listeners = [];
  const first = curves[start];
  const state = first
    ? {mode: first.mode, level: first.level, channel: first.channel, sweep: sweepOf(first), frequency: null}
    : {mode: null, level: ALL, channel: null, sweep: BOTH, frequency: null};

  // What can be chosen, given what stands before it in the row of selectors.
  function choices() {
    const modes = updamp.unique(curves.map(curve => curve.mode));
    const inMode = curves.filter(curve => curve.mode === state.mode);
    const levels = updamp.unique(inMode.map(curve => curve.level)).sort((a, b) => a - b);
    const channels = updamp.unique(inMode.map(curve => curve.channel));
    const atLevel = inMode.filter(curve => state.level === ALL || curve.level === state.level);
    const sweeps = updamp.unique(atLevel.map(sweepOf));
    return {
      mode: modes,
      level: levels.length > 1 ? [...levels, ALL] : levels,
      channel: channels,
      sweep: sweeps.length > 1 ? [...sweeps, BOTH] : sweeps,
    };
  }

  function select(change) {
    Object.assign(state, {frequency: null}, change);
    for (const key of ["mode", "level", "channel", "sweep"]) {
      const possible = choices()[key];
      if (!possible.includes(state[key])) state[key] = possible[0];
    }
    listeners.forEach(listener => listener(state));
  }

  // The chosen among things with mode, channel, level and up; a level or sweep of its own can be left open.
  function chosen(things, {anyLevel = false} = {}) {
    return things.filter(thing => state.mode === null || (
      thing.mode === state.mode && thing.channel === state.channel
      && (anyLevel || state.level === ALL || thing.level === state.level)
      && (thing.up === undefined || state.sweep === BOTH || sweepOf(thing) === state.sweep)));
  }

  const WORDS = {all: "all levels", up: "▲ upwards", down: "▼ downwards", both: "both"};
  const nameOf = value => (typeof value === "number" ? updamp.levelName(value) : WORDS[value] || value);

  function sentence() {
    const level = state.level === ALL ? `all ${updamp.levelWord}s` : updamp.levelName(state.level);
    const sweep = state.sweep === BOTH ? "both sweep directions" : `sweep ${state.sweep}wards`;
    const mark = state.frequency === null ? "" : `, ${updamp.digits(state.frequency, 6)} Hz marked`;
    return `Shown: ${state.mode}, ${level}, ${state.channel}, ${sweep}${mark}.`;
  }

  function showControls() {
    const possible = choices();
    for (const key of Object.keys(possible)) {
      const element = document.getElementById(`select-${key}`);
      element.replaceChildren(...possible[key].map((value, i) => new Option(nameOf(value), i, false, value === state[key])));
      element.disabled = possible[key].length < 2;
    }
    document.getElementById("selection").textContent = sentence();
  }

  if (curves.length > 0) {
    for (const key of ["mode", "level", "channel", "sweep"]) {
      document.getElementById(`select-${key}`).addEventListener("change", event => {
        select({[key]: choices()[key][Number(event.target.value)]});
      });
    }
    listeners.push(showControls);
    updamp.whenReady(showControls);
  }
  const levels = updamp.unique(curves.map(curve => curve.level)).sort((a, b) => a - b);

  // Few levels are told apart by hue, many by their place on a scale.
  function colourOf(level) {
    const {levels: few, many} = updamp.palette;
    const place = Math.max(levels.indexOf(level), 0);
    if (levels.length <= few.length) return few[place];
    const at = place / (levels.length - 1) * (many.length - 1), from = Math.min(Math.floor(at), many.length - 2);
    const channel = (colour, k) => parseInt(colour.slice(1 + 2 * k, 3 + 2 * k), 16);
    const mixed = [0, 1, 2].map(k => Math.round(channel(many[from], k) + (at - from) * (channel(many[from + 1], k) - channel(many[from], k))));
    return `rgb(${mixed.join(",")})`;
  }

  return {
    ALL, BOTH, state, select, chosen,
    onChange: listener => { listeners.push(listener); updamp.whenReady(() => listener(state)); },
    colourOf,
    symbolOf: repeat => ["circle-open", "square-open", "diamond-open", "cross-open", "star-open", "hexagon-open"][
      (((repeat - 1) % 6) + 6) % 6],
  };
})();
