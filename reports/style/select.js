// Which engine, live: the score of harness/findings/selection/rank.py, over weights and requirements that a reader sets.
"use strict";

(() => {
  const source = document.getElementById("evidence");
  if (!source) return;
  const { criteria, families, cases, engines, cells, costs, presets, sentences, few, own, asked, others } = JSON.parse(source.textContent);
  const DRAWS = 2000, CONCENTRATION = 30, APART = 0.99, EQUAL = 1e-12;
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

  // Is there a scene among those that count which an engine can express?
  const capability = criteria.indexOf("capability");
  const expresses = (e) => {
    const known = capability < 0 ? [] : cases.map((_, c) => c).filter((c) => weightOfCase(c) > 0 && has[capability * C + c]);
    return !known.length || known.some((c) => value[at(capability, c, e)] > 0);
  };

  const NOTHING = "expresses none of the scenes";
  const leftOut = () => {
    const reasons = new Map(), open = new Map();
    engines.forEach((engine, e) => {
      if (wish.feature && !engine.features.includes(wish.feature)) reasons.set(e, `does not claim ${wish.feature.replaceAll("_", " ")}`);
      else if (!expresses(e)) reasons.set(e, NOTHING);
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
  const filled = (name, values) => sentences[name].replace(/\{(\w+)\}/g, (_, key) => values[key]);
  const listed = (names) => (names.length > 1 ? `${names.slice(0, -1).join(", ")} and ${names.at(-1)}` : names[0]);

  // The first sentence, as `headline` of harness/findings/selection/words.py has it, in the same words.
  const headline = (places, reasons) => {
    const counted = cases.map((_, c) => c).filter((c) => weightOfCase(c) > 0), titled = (place) => engines[place.engine].title;
    const told = criteria.some((_, k) => wish.weights[k] > 0 && counted.some((c) => has[k * C + c]));
    if (!places.length || !told) return filled(reasons.size || others ? "none" : "unknown", {});
    const scenes = counted.length === 1 ? "this scene" : "these scenes";
    if (places.length === 1) {
      const all = !others && [...reasons.values()].every((why) => why === NOTHING);
      return filled(asked === 1 ? "single" : all ? "expresses" : "left", { engine: titled(places[0]), scenes, asked });
    }
    const level = places.filter((place) => place.number === 1), share = percent(level[0].first);
    const shares = level.map((place) => `${titled(place)} ${percent(place.first)}`).join(", ");
    const first = filled(level.length === 1 ? "first" : "level", { engine: titled(level[0]), engines: listed(level.map(titled)), share, shares, draws: DRAWS });
    if (counted.length >= few || counted.every((c) => own.includes(c))) return first;
    return `${first} ${filled("few", { cases: `${counted.length} case${counted.length === 1 ? "" : "s"}` })}`;
  };

  const show = () => {
    const { reasons, open } = leftOut(), left = engines.map((_, e) => e).filter((e) => !reasons.has(e));
    const out = [...reasons].map(([e, why]) => (why === NOTHING ? filled("expressed", { engine: engines[e].title }) : `${engines[e].title} is left out: ${why}.`));
    for (const [e, what] of open) if (!reasons.has(e)) out.push(`Of ${engines[e].title} it is not known: ${what}.`);
    document.getElementById("left-out").textContent = out.join(" ");
    document.getElementById("why").textContent = wish.preset ? `${wish.preset.title}: ${wish.preset.why}` : "";
    const places = left.length ? rank(left) : [];
    document.getElementById("headline").textContent = headline(places, reasons).replaceAll(" %", "\u00a0%");
    const body = document.querySelector("#places tbody"), rows = new Map([...body.rows].map((row) => [row.dataset.engine, row]));
    for (const row of rows.values()) row.hidden = true;
    for (const place of places) {
      const row = rows.get(engines[place.engine].name);
      row.hidden = false;
      row.cells[0].textContent = place.number;
      row.cells[3].textContent = places.length > 1 ? percent(place.first) : "–";
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

  const purposes = grouped("For");
  const preset = document.createElement("select");
  preset.append(new Option("everything alike", ""));
  for (const one of presets.filter((p) => cases.some((c) => p.cases[c.name] > 0))) preset.append(new Option(one.title, one.name));
  labelled("purpose", preset, purposes);
  const feature = document.createElement("select");
  feature.append(new Option("any", ""));
  for (const name of [...new Set(engines.flatMap((e) => e.features))].sort()) feature.append(new Option(name.replaceAll("_", " "), name));
  labelled("has to have", feature, purposes);
  const realtime = document.createElement("input");
  Object.assign(realtime, { type: "number", min: 0, step: 1, value: 0 });
  labelled("times real time, at least", realtime, purposes);

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
