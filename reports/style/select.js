// Which engine, live: the score of harness/findings/selection/rank.py with its very numbers, over weights that a reader sets.
"use strict";

(() => {
  const source = document.getElementById("evidence");
  if (!source) return;
  const { draws, seed, doubt, decades, clear, few, sentences, purposes } = JSON.parse(source.textContent);
  const EQUAL = 1e-12, NOTHING = "expresses none of the scenes";

  // The generator of rank.py (mulberry32), each number in the same order.
  const generator = (state) => () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const normal = (random) => {
    const one = random(), two = random();
    return Math.sqrt(-2 * Math.log(1 - one)) * Math.cos(2 * Math.PI * two);
  };

  // What the reader wishes: of one purpose, its weights and those of families and requirements.
  const wish = { purpose: purposes[0], weights: [...purposes[0].weights], families: {}, realtime: 0, feature: "" };
  const weightOf = (one) => one.weight * (wish.families[one.family] ?? 1);
  const useful = (times) => (times > 0 && Number.isFinite(times) ? Math.min(1, Math.max(0, 1 - Math.log10(times) / decades)) : 0);

  // What is known of the engines left in the cases that count: values, low and high ends by criterion, case and engine.
  const table = (left) => {
    const { criteria, cases, cells } = wish.purpose;
    const ks = criteria.map((_, k) => k).filter((k) => wish.weights[k] > 0 && cells.some((cell) => cell[0] === k));
    const cs = cases.map((_, c) => c).filter((c) => weightOf(cases[c]) > 0);
    const at = (k, c, e) => (k * cs.length + c) * left.length + e, size = ks.length * cs.length * left.length;
    const value = new Float64Array(size), low = new Float64Array(size), high = new Float64Array(size);
    const has = new Uint8Array(ks.length * cs.length), fastest = new Map();
    for (const [k, c, e, times] of cells)
      if (criteria[k] === "speed" && left.includes(e)) fastest.set(c, Math.max(times, fastest.get(c) ?? 0));
    for (const [k, c, e, ...figures] of cells) {
      const i = ks.indexOf(k), j = cs.indexOf(c), n = left.indexOf(e);
      if (i < 0 || j < 0 || n < 0 || (criteria[k] === "speed" && !fastest.get(c))) continue;
      const known = criteria[k] === "speed" ? figures.slice(0, 3).map((times) => useful(fastest.get(c) / times)) : figures;
      [value[at(i, j, n)], low[at(i, j, n)], high[at(i, j, n)]] = known;
      has[i * cs.length + j] = 1;
    }
    return { ks, cs, at, value, low, high, has };
  };

  const scores = (left, { ks, cs, at, has }, value, ofCases, weights) => {
    const totals = new Float64Array(left.length);
    let whole = 0;
    for (let k = 0; k < ks.length; k++) {
      let sum = 0;
      const means = new Float64Array(left.length);
      for (let c = 0; c < cs.length; c++) {
        if (!has[k * cs.length + c] || !ofCases[c]) continue;
        sum += ofCases[c];
        for (let e = 0; e < left.length; e++) means[e] += ofCases[c] * value[at(k, c, e)];
      }
      if (sum <= 0) continue;
      whole += weights[k];
      for (let e = 0; e < left.length; e++) totals[e] += (weights[k] * means[e]) / sum;
    }
    return totals.map((total) => (whole > 0 ? total / whole : 0));
  };

  const rank = (left) => {
    const known = table(left), { ks, cs, at, value, low, high } = known;
    if (!ks.length || !cs.length) return { places: [], known };
    const ofCases = cs.map((c) => weightOf(wish.purpose.cases[c])), weights = ks.map((k) => wish.weights[k]);
    const middle = scores(left, known, value, ofCases, weights), first = left.map(() => 0), random = generator(seed);
    const count = cs.length, drawn = new Float64Array(count), moved = value.slice();
    for (let n = 0; n < draws; n++) {
      drawn.fill(0);
      for (let c = 0; c < Math.max(count - 1, 1); c++) drawn[Math.floor(random() * count)] += 1;
      for (let c = 0; c < count; c++) {
        drawn[c] *= ofCases[c];
        for (let e = 0; e < left.length; e++) {
          const up = Math.max(-1, Math.min(1, normal(random) / 1.96));
          for (let k = 0; k < ks.length; k++) {
            const i = at(k, c, e);
            moved[i] = value[i] + (up > 0 ? up * (high[i] - value[i]) : up * (value[i] - low[i]));
          }
        }
      }
      const mixed = weights.map((weight) => weight * Math.exp(doubt * normal(random)));
      const found = scores(left, known, moved, drawn, mixed), best = Math.max(...found);
      const leaders = found.filter((s) => s >= best - EQUAL).length;
      found.forEach((s, a) => s >= best - EQUAL && (first[a] += 1 / leaders));
    }
    // Divided once, as rank.py does: a sum of shares would round another way, and 67.5 % be another whole number.
    for (const a of first.keys()) first[a] /= draws;
    const names = left.map((e) => wish.purpose.engines[e].name);
    const order = left.map((_, a) => a).sort((a, b) => first[b] - first[a] || middle[b] - middle[a] || (names[a] < names[b] ? -1 : 1));
    return { places: order.map((a) => ({ engine: left[a], column: a, score: middle[a], first: first[a] })), known };
  };

  // Is there a scene among those that count which an engine can express?
  const expresses = (e) => {
    const { criteria, cases, cells } = wish.purpose, capability = criteria.indexOf("capability");
    const told = cells.filter(([k, c, of]) => k === capability && of === e && weightOf(cases[c]) > 0);
    return !told.length || told.some((cell) => cell[3] > 0);
  };

  const leftOut = () => {
    const reasons = new Map(), open = new Map(), { criteria, engines, cases, cells } = wish.purpose;
    engines.forEach((engine, e) => {
      if (wish.feature && !engine.features.includes(wish.feature)) reasons.set(e, `does not claim ${wish.feature.replaceAll("_", " ")}`);
      else if (!expresses(e)) reasons.set(e, NOTHING);
    });
    for (const [k, c, e, times, , , bound] of wish.realtime > 0 ? cells : []) {
      if (criteria[k] !== "speed" || reasons.has(e) || weightOf(cases[c]) <= 0 || times >= wish.realtime) continue;
      const words = times ? `${Number(times.toPrecision(3))} times real time in ${cases[c].title}` : `no run passes its checks in ${cases[c].title}`;
      if (bound) open.has(e) || open.set(e, `${words}, and no larger step was run`);
      else reasons.set(e, words);
    }
    return { reasons, open };
  };

  const meanOf = ({ ks, cs, at, value, has }, criterion, column) => {
    const k = ks.findIndex((of) => wish.purpose.criteria[of] === criterion);
    let sum = 0, whole = 0;
    for (let c = 0; k >= 0 && c < cs.length; c++) {
      const weight = weightOf(wish.purpose.cases[cs[c]]) * has[k * cs.length + c];
      sum += weight * (weight ? value[at(k, c, column)] : 0);
      whole += weight;
    }
    return whole > 0 ? (sum / whole).toFixed(2) : "\u2013";
  };

  const percent = (share) => `${Math.floor(100 * share + 0.5)} %`;
  const filled = (name, values) => sentences[name].replace(/\{(\w+)\}/g, (_, key) => values[key]);

  // The first sentence, as `headline` of harness/findings/selection/words.py has it, in the same words.
  const headline = (places, known, reasons) => {
    const { cases, engines, asked, others } = wish.purpose, titled = (place) => engines[place.engine].title;
    const counted = cases.filter((one) => weightOf(one) > 0);
    if (!places.length || !known.has.some((one) => one)) return filled(reasons.size || others ? "none" : "unknown", {});
    const scenes = counted.length === 1 ? "this scene" : "these scenes";
    if (places.length === 1) {
      const all = !others && [...reasons.values()].every((why) => why === NOTHING);
      return filled(asked === 1 ? "single" : all ? "expresses" : "left", { engine: titled(places[0]), scenes, asked });
    }
    const [first, ...rest] = places, seen = rest.filter((place) => percent(place.first) !== percent(0));
    const told = (seen.length ? seen : rest.slice(0, 1)).map((place) => `${titled(place)} in ${percent(place.first)}`).join(", ");
    const values = { engine: titled(first), share: percent(first.first), second: titled(rest[0]), others: told };
    const sentence = filled(first.first > clear ? "first" : "open", values);
    if (counted.length >= few || counted.every((one) => one.own)) return sentence;
    return `${sentence} ${filled("few", { cases: `${counted.length} case${counted.length === 1 ? "" : "s"}` })}`;
  };

  const show = () => {
    const { engines } = wish.purpose, { reasons, open } = leftOut(), left = engines.map((_, e) => e).filter((e) => !reasons.has(e));
    const out = [...reasons].map(([e, why]) => (why === NOTHING ? filled("expressed", { engine: engines[e].title }) : `${engines[e].title} is excluded: ${why}.`));
    for (const [e, what] of open) if (!reasons.has(e)) out.push(`Of ${engines[e].title} it is not known: ${what}.`);
    document.getElementById("left-out").textContent = out.join(" ");
    document.getElementById("purpose").textContent = wish.purpose.name ? wish.purpose.title : "All cases alike";
    for (const part of document.querySelectorAll("[data-evidence]")) part.hidden = part.dataset.evidence !== wish.purpose.name;
    document.getElementById("why").textContent = wish.purpose.name ? `${wish.purpose.title}: ${wish.purpose.why}` : "";
    const { places, known } = left.length ? rank(left) : { places: [], known: { has: [] } };
    document.getElementById("headline").textContent = headline(places, known, reasons).replaceAll(" %", "\u00a0%");
    const body = document.querySelector("#places tbody"), rows = new Map([...body.rows].map((row) => [row.dataset.engine, row]));
    const columns = [...document.querySelectorAll("#places th[data-criterion]")].map((head) => head.dataset.criterion);
    for (const row of rows.values()) row.hidden = true;
    places.forEach((place, at) => {
      const { name, setting, shown } = engines[place.engine], row = rows.get(name);
      row.hidden = false;
      const cells = [at + 1, null, setting, places.length > 1 ? percent(place.first) : "\u2013", ...shown.map((figure) => figure || "\u2013"), place.score.toFixed(2)];
      cells.push(...columns.map((criterion) => meanOf(known, criterion, place.column)));
      cells.forEach((text, cell) => text !== null && (row.cells[cell].textContent = text));
      body.append(row);
    });
    // What is said beside an answer holds of the purpose's own weights alone.
    document.getElementById("turns").replaceChildren(...(touched ? [] : wish.purpose.notes).map((text) => {
      const item = document.createElement("li");
      item.textContent = text;
      return item;
    }));
    const command = document.getElementById("command");
    command.hidden = touched || !wish.purpose.command;
    command.textContent = wish.purpose.command;
  };

  let touched = false, waiting = 0;
  const changed = (own = true) => {
    touched = own;
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

  const everything = purposes[0], chosen = grouped("For");
  const preset = document.createElement("select");
  for (const one of purposes) preset.append(new Option(one.title, one.name));
  labelled("purpose", preset, chosen);
  const feature = document.createElement("select");
  feature.append(new Option("any", ""));
  for (const name of [...new Set(everything.engines.flatMap((e) => e.features))].sort()) feature.append(new Option(name.replaceAll("_", " "), name));
  labelled("has to have", feature, chosen);
  const realtime = document.createElement("input");
  Object.assign(realtime, { type: "number", min: 0, step: 1, value: 0 });
  labelled("times real time, at least", realtime, chosen);

  const byCriterion = grouped("What counts");
  const setWeight = (name, x) => {
    const k = wish.purpose.criteria.indexOf(name);
    if (k >= 0) wish.weights[k] = x;
  };
  const sliders = everything.criteria.map((name) => ({ name, ...slider(name, byCriterion, (x) => setWeight(name, x)) }));
  const byFamily = grouped("Which cases count");
  for (const family of everything.families) slider(family.title, byFamily, (x) => (wish.families[family.name] = x));

  const choose = (name) => {
    wish.purpose = purposes.find((one) => one.name === name) ?? everything;
    preset.value = wish.purpose.name;
    wish.weights = [...wish.purpose.weights];
    for (const { name: criterion, input, output } of sliders)
      input.value = output.textContent = wish.weights[wish.purpose.criteria.indexOf(criterion)] ?? 0;
    changed(false);
  };
  preset.addEventListener("change", () => choose(preset.value));
  feature.addEventListener("change", () => {
    wish.feature = feature.value;
    changed();
  });
  realtime.addEventListener("input", () => {
    wish.realtime = Math.max(0, Number(realtime.value) || 0);
    changed();
  });
  const asked = new URLSearchParams(location.search).get("for");
  if (purposes.some((one) => one.name && one.name === asked)) choose(asked);
})();
