// Which engine, live: the score of harness/findings/selection/rank.py, over weights and requirements that a reader sets.
"use strict";

(() => {
  const source = document.getElementById("evidence");
  if (!source) return;
  const { criteria, families, cases, engines, cells, costs, presets } = JSON.parse(source.textContent);
  const DRAWS = 2000, CONCENTRATION = 30, APART = 0.99, EQUAL = 1e-12, FEW = 8;
  const K = criteria.length, C = cases.length, E = engines.length;
  const at = (k, c, e) => (k * C + c) * E + e;
  const value = new Float64Array(K * C * E), low = value.slice(), high = value.slice(), has = new Uint8Array(K * C), bounded = new Uint8Array(K * C * E);
  for (const [k, c, e, middle, below, above, bound] of cells) {
    bounded[at(k, c, e)] = bound;
    value[at(k, c, e)] = middle;
    low[at(k, c, e)] = below;
    high[at(k, c, e)] = above;
    has[k * C + c] = 1;
  }

  // The same numbers for the same wishes: a small generator of a fixed seed (mulberry32).
  const generator = (seed) => () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const normal = (random) => Math.sqrt(-2 * Math.log(1 - random())) * Math.cos(2 * Math.PI * random());
  // Marsaglia & Tsang (2000); below 1 by a power of a uniform number.
  const gamma = (shape, random) => {
    if (shape < 1) return gamma(shape + 1, random) * Math.pow(1 - random(), 1 / shape);
    const d = shape - 1 / 3, c = 1 / Math.sqrt(9 * d);
    for (;;) {
      const x = normal(random), v = Math.pow(1 + c * x, 3);
      if (v > 0 && Math.log(1 - random()) < 0.5 * x * x + d - d * v + d * Math.log(v)) return d * v;
    }
  };

  // sides: of each engine, whether its bounds stand for all that they leave open (1) or for no more than they show (0).
  const scores = (left, weightsOfCases, weights, within, sides) => {
    const totals = new Float64Array(E);
    let whole = 0;
    for (let k = 0; k < K; k++) {
      let sum = 0;
      const means = new Float64Array(E);
      for (let c = 0; c < C; c++) {
        if (!has[k * C + c] || !weightsOfCases[c]) continue;
        sum += weightsOfCases[c];
        for (const e of left) {
          const i = at(k, c, e), up = within ? (bounded[i] ? sides[e] * 2 - 1 : within[c * E + e]) : 0;
          means[e] += weightsOfCases[c] * (value[i] + (up > 0 ? up * (high[i] - value[i]) : up * (value[i] - low[i])));
        }
      }
      if (sum <= 0 || weights[k] <= 0) continue;
      whole += weights[k];
      for (const e of left) totals[e] += (weights[k] * means[e]) / sum;
    }
    return left.map((e) => (whole > 0 ? totals[e] / whole : 0));
  };

  // What the reader wishes.
  const wish = { weights: criteria.map(() => 1), families: Object.fromEntries(families.map((f) => [f.name, 1])), preset: null, realtime: 0, feature: "" };
  const weightOfCase = (c) => (wish.preset ? wish.preset.cases[cases[c].name] : 1) * wish.families[cases[c].family];

  const leftOut = () => {
    const reasons = new Map(), open = new Map();
    engines.forEach((engine, e) => {
      if (wish.feature && !engine.features.includes(wish.feature)) reasons.set(e, `does not claim ${wish.feature.replaceAll("_", " ")}`);
    });
    if (wish.realtime > 0) {
      for (const [c, e, cost, bound] of costs) {
        if (reasons.has(e) || weightOfCase(c) <= 0) continue;
        if (cost === null) reasons.set(e, `does not come to the error asked for in ${cases[c].title}`);
        else if (cost * wish.realtime > 1 && bound) open.has(e) || open.set(e, `${(1 / cost).toPrecision(3)} times real time or more in ${cases[c].title}`);
        else if (cost * wish.realtime > 1) reasons.set(e, `${(1 / cost).toPrecision(3)} times real time in ${cases[c].title}`);
      }
    }
    return { reasons, open };
  };

  const rank = (left) => {
    const weights = wish.weights, ofCases = cases.map((_, c) => weightOfCase(c));
    const middle = scores(left, ofCases, weights, null, null);
    const first = left.map(() => 0), ahead = left.map(() => left.map(() => 0));
    const random = generator(1), total = weights.reduce((a, b) => a + b, 0) || 1;
    const drawn = new Float64Array(C), within = new Float64Array(C * E), mixed = new Float64Array(K), sides = new Uint8Array(E);
    for (let n = 0; n < DRAWS; n++) {
      drawn.fill(0);
      for (let c = 0; c < Math.max(C - 1, 1); c++) drawn[Math.floor(random() * C)] += 1;
      for (let c = 0; c < C; c++) drawn[c] *= ofCases[c];
      for (let i = 0; i < C * E; i++) within[i] = Math.max(-1, Math.min(1, normal(random) / 1.96));
      for (let e = 0; e < E; e++) sides[e] = random() < 0.5 ? 0 : 1;
      for (let k = 0; k < K; k++) mixed[k] = weights[k] > 0 ? gamma((CONCENTRATION * weights[k]) / total, random) : 0;
      const found = scores(left, drawn, mixed, within, sides), best = Math.max(...found);
      const leaders = found.filter((s) => s >= best - EQUAL).length;
      found.forEach((s, a) => {
        if (s >= best - EQUAL) first[a] += 1 / leaders / DRAWS;
        found.forEach((other, b) => (ahead[a][b] += (s - other > EQUAL ? 1 : Math.abs(s - other) <= EQUAL ? 0.5 : 0) / DRAWS));
      });
    }
    const order = left.map((_, a) => a).sort((a, b) => first[b] - first[a] || middle[b] - middle[a]);
    const numbers = new Map();
    let number = 1;
    order.forEach((a, place) => {
      const apart = order.slice(0, place).every((before) => order.slice(place).every((after) => ahead[before][after] >= APART));
      if (place && apart) number = place + 1;
      numbers.set(a, number);
    });
    return order.map((a) => ({ engine: left[a], number: numbers.get(a), score: middle[a], first: first[a] }));
  };

  const meanOf = (k, e) => {
    let sum = 0, whole = 0;
    for (let c = 0; c < C; c++) {
      const weight = weightOfCase(c) * has[k * C + c];
      sum += weight * value[at(k, c, e)];
      whole += weight;
    }
    return whole > 0 ? (sum / whole).toFixed(2) : "–";
  };

  const percent = (share) => `${Math.round(100 * share)} %`;
  const show = () => {
    const { reasons, open } = leftOut(), left = engines.map((_, e) => e).filter((e) => !reasons.has(e));
    const out = [...reasons].map(([e, why]) => `${engines[e].title} is left out: ${why}.`);
    for (const [e, what] of open) if (!reasons.has(e)) out.push(`Of ${engines[e].title} it is not known: ${what}.`);
    document.getElementById("left-out").textContent = out.join(" ");
    document.getElementById("why").textContent = wish.preset ? `${wish.preset.title}: ${wish.preset.why}` : "";
    const places = left.length ? rank(left) : [];
    const level = places.filter((p) => p.number === 1), words = document.getElementById("headline");
    const shares = level.map((p) => `${engines[p.engine].title} ${percent(p.first)}`).join(", ");
    if (!places.length) words.textContent = "No engine is left.";
    else if (places.length === 1) words.textContent = `${engines[places[0].engine].title}, the only engine left.`;
    else if (level.length === 1) words.textContent = `${engines[level[0].engine].title} first, in ${percent(level[0].first)} of ${DRAWS} draws.`;
    else words.textContent = `Level: no order holds in 99 % of ${DRAWS} draws (first: ${shares}).`;
    const counted = cases.filter((_, c) => weightOfCase(c) > 0).length;
    if (places.length && counted < FEW) words.textContent += ` It leans on ${counted} of the cases alone: too few for a share to mean much.`;
    const body = document.querySelector("#places tbody"), rows = new Map([...body.rows].map((row) => [row.dataset.engine, row]));
    for (const row of rows.values()) row.hidden = true;
    for (const place of places) {
      const row = rows.get(engines[place.engine].name);
      row.hidden = false;
      row.cells[0].textContent = place.number;
      row.cells[3].textContent = percent(place.first);
      row.cells[4].textContent = place.score.toFixed(2);
      criteria.forEach((_, k) => (row.cells[5 + k].textContent = meanOf(k, place.engine)));
      body.append(row);
    }
    // What was said of equal weights holds of these alone.
    document.getElementById("turns").hidden = touched;
  };

  let touched = false, waiting = 0;
  const changed = () => {
    touched = true;
    clearTimeout(waiting);
    waiting = setTimeout(show, 60);
  };

  const controls = document.getElementById("controls");
  const labelled = (text, input, group) => {
    const label = document.createElement("label"), name = document.createElement("span");
    name.textContent = text;
    label.append(name, input);
    group.append(label);
    return label;
  };
  const grouped = (title) => {
    const group = document.createElement("fieldset"), legend = document.createElement("legend");
    legend.textContent = title;
    group.append(legend);
    group.className = "wishes";
    controls.append(group);
    return group;
  };
  const slider = (text, group, set) => {
    const input = document.createElement("input"), output = document.createElement("output");
    Object.assign(input, { type: "range", min: 0, max: 5, step: 0.5, value: 1 });
    output.textContent = "1";
    input.addEventListener("input", () => {
      output.textContent = input.value;
      set(Number(input.value));
      changed();
    });
    labelled(text, input, group).append(output);
    return { input, output };
  };

  const asked = grouped("For");
  const preset = document.createElement("select");
  preset.append(new Option("everything alike", ""));
  for (const one of presets.filter((p) => cases.some((c) => p.cases[c.name] > 0))) preset.append(new Option(one.title, one.name));
  labelled("purpose", preset, asked);
  const feature = document.createElement("select");
  feature.append(new Option("any", ""));
  for (const name of [...new Set(engines.flatMap((e) => e.features))].sort()) feature.append(new Option(name.replaceAll("_", " "), name));
  labelled("has to have", feature, asked);
  const realtime = document.createElement("input");
  Object.assign(realtime, { type: "number", min: 0, step: 1, value: 0 });
  labelled("times real time, at least", realtime, asked);

  const byCriterion = grouped("What counts");
  const sliders = criteria.map((name, k) => slider(name, byCriterion, (x) => (wish.weights[k] = x)));
  const byFamily = grouped("Which cases count");
  for (const family of families) slider(family.title, byFamily, (x) => (wish.families[family.name] = x));

  preset.addEventListener("change", () => {
    wish.preset = presets.find((one) => one.name === preset.value) ?? null;
    criteria.forEach((name, k) => {
      wish.weights[k] = wish.preset ? wish.preset.weights[name] : 1;
      sliders[k].input.value = sliders[k].output.textContent = wish.weights[k];
    });
    changed();
  });
  feature.addEventListener("change", () => {
    wish.feature = feature.value;
    changed();
  });
  realtime.addEventListener("input", () => {
    wish.realtime = Math.max(0, Number(realtime.value) || 0);
    changed();
  });
})();
