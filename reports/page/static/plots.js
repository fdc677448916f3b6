// The motion's quantities and every engine's difference from the truth against time, linked to the player's time and
// setting.
suite.plots = (place, player) => {
  const { motion } = player, { truth, t } = motion, drawn = [];
  const PANELS = [["slip", "slip velocity v, m/s"], ["angle", "rotation θ, rad"], ["x", "centre X, m"], ["y", "centre Y, m"], ["normal", "normal force N, N (truth)"]];
  const DISTANCES = [["centre", "centre, m"], ["angle", "rotation, rad"], ["slip", "slip velocity, m/s"]];
  place.innerHTML = PANELS.map(([name, title]) => `<div class="panel" data-of="${name}"><h4>${title}</h4></div>`).join("")
    + `<div class="panel" data-of="distance"><h4>distance from the truth: <select aria-label="quantity of the distance">${DISTANCES.map(([name, title]) => `<option value="${name}">${title}</option>`).join("")}</select></h4></div>`;
  const choice = place.querySelector("select");
  const times = Array.from(t);
  const size = (name, run) => times.map((_, i) => {
    const off = name === "centre" ? Math.hypot(run.off.x[i], run.off.y[i]) : Math.abs(run.off[name][i]);
    return off > 0 ? Math.max(off, 1e-18) : null;
  });
  const sum = (name, run) => times.map((_, i) => { const v = truth[name][i] + run.off[name][i]; return Number.isFinite(v) ? v : null; });
  // About four powers of ten on a logarithmic axis.
  const powers = (_, __, low, high) => {
    const from = Math.ceil(Math.log10(low) - 1e-9), to = Math.floor(Math.log10(high) + 1e-9), step = Math.max(1, Math.ceil((to - from) / 4));
    return Array.from({ length: Math.floor((to - from) / step) + 1 }, (_, i) => 10 ** (from + i * step));
  };
  const power = (v) => `1e${Math.round(Math.log10(v))}`;

  // The truth sets the axis range: a noisy force of one engine must not flatten all curves.
  const room = (values) => {
    const numbers = values.filter((v) => v !== null), low = Math.min(...numbers), high = Math.max(...numbers);
    const more = 0.08 * (high - low > 1e-6 * Math.abs(high) ? high - low : Math.abs(high) || 1);
    return numbers.length ? [low - more, high + more] : [0, 1];
  };

  function one(panel, title, data, series, logarithmic) {
    const ink = suite.colour("--soft"), line = suite.colour("--line"), text = { stroke: ink, font: "11px system-ui", grid: { stroke: line, width: 1 }, ticks: { show: false } };
    const chart = new uPlot({
      width: Math.max(200, panel.clientWidth), height: 150, legend: { show: false },
      cursor: { sync: { key: motion.label }, drag: { x: false, y: false }, points: { size: 5 } },
      scales: { x: { time: false }, y: logarithmic ? { distr: 3 } : { range: room(data[1]) } },
      axes: [{ ...text, size: 26 }, { ...text, size: 52, ...(logarithmic ? { splits: powers, filter: (_, all) => all } : {}), values: (_, all) => all.map((v) => (v === null ? "" : logarithmic ? power(v) : suite.digits(v, 3))) }],
      series: [{}, ...series],
    }, data, panel);
    chart.root.setAttribute("role", "img");
    chart.root.setAttribute("aria-label", `${title} against time for ${motion.label}; its numbers are in the tables`);
    const needle = chart.over.appendChild(document.createElement("span"));
    needle.className = "needle";
    const go = (event) => { player.play(false); player.seek(chart.posToVal(event.offsetX, "x")); };
    chart.over.addEventListener("pointerdown", (event) => { if (event.target === chart.over) { chart.over.setPointerCapture(event.pointerId); go(event); } });
    chart.over.addEventListener("pointermove", (event) => { if (event.buttons && event.target === chart.over) go(event); });
    drawn.push({ chart, needle });
  }

  function draw() {
    drawn.splice(0).forEach(({ chart }) => chart.destroy());
    const shown = player.runs().filter((run) => suite.on(run.solver, run.route));
    const series = shown.map((run) => ({ label: `${run.solver} ${run.route}`, stroke: suite.colourOf(run.solver), width: 1.4, dash: run.route === "native" ? [] : [6, 3], points: { show: false } }));
    for (const [name, title] of PANELS) {
      const exact = { label: "truth", stroke: suite.colour("--truth"), width: 3.5, points: { show: false } };
      const exactly = Array.from(truth[name], (v) => (Number.isFinite(v) ? v : null)), isOfEngines = name in (shown[0]?.off ?? {});
      one(place.querySelector(`[data-of=${name}]`), title, [times, exactly, ...(isOfEngines ? shown.map((run) => sum(name, run)) : [])], [exact, ...(isOfEngines ? series : [])], false);
    }
    const panel = place.querySelector("[data-of=distance]");
    const sizes = shown.map((run) => size(choice.value, run));
    if (sizes.some((values) => values.some((v) => v !== null)))
      one(panel, "distance from the truth", [times, ...sizes], series, true);
    player.seek(player.time());
  }
  const move = (time) => drawn.forEach(({ chart, needle }) => { needle.style.left = `${chart.valToPos(time, "x")}px`; });
  choice.addEventListener("change", draw);
  suite.whenSwitched(() => place.offsetParent !== null && draw());
  new ResizeObserver(() => drawn.forEach(({ chart }) => chart.setSize({ width: Math.max(200, chart.root.parentElement.clientWidth), height: 150 }))).observe(place);
  player.whenChosen(() => place.offsetParent !== null && draw());
  player.whenMoved(move);
  draw();
};
