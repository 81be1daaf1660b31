// Live charts, sortable and filterable tables. Without this script the page still says everything.
"use strict";

(() => {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");

  // The same names as LIGHT in reports/figure.py.
  const scheme = () => {
    const [paper, ink, soft, line, grid] = dark.matches
      ? ["#15191f", "#e4e8ee", "#9aa5b4", "#3a434f", "#252c35"]
      : ["#ffffff", "#1d232c", "#4a5361", "#9aa3b0", "#e9ecf1"];
    return {
      background: paper,
      font: getComputedStyle(document.body).fontFamily,
      view: { stroke: grid },
      axis: {
        gridColor: grid, domainColor: line, tickColor: line, labelColor: soft, titleColor: ink,
        titleFontWeight: 500, labelFontSize: 11, titleFontSize: 12, labelSeparation: 5,
      },
      legend: { labelColor: ink, titleColor: soft, titleFontWeight: 500, labelFontSize: 12 },
    };
  };

  // The one notation of powers, as `amount` of reports/text.py writes them: 2.6\u00d710\u207b\u2076 for 2.6e-6.
  const SUPERSCRIPTS = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";
  const power = (text) => {
    const [, mantissa, minus, digits] = /^([-\u2212]?[\d.]+)e([+-])(\d+)$/.exec(text) ?? [];
    if (!digits) return text;
    const exponent = (minus === "-" ? "\u207b" : "") + [...digits].map((digit) => SUPERSCRIPTS[digit]).join("");
    const shown = mantissa.includes(".") ? mantissa.replace(/0+$/, "").replace(/\.$/, "") : mantissa;
    return shown === "1" ? `10${exponent}` : `${shown}\u00d710${exponent}`;
  };

  // A tooltip of text nodes: nothing in a value can become an element.
  const box = document.createElement("div");
  box.id = "hover";
  box.setAttribute("role", "tooltip");
  document.body.append(box);
  const hover = (_, event, __, value) => {
    if (!value || typeof value !== "object") {
      box.style.display = "none";
      return;
    }
    const list = document.createElement("dl");
    for (const [name, text] of Object.entries(value)) {
      if (text === "" || text === "null" || text === null || text === undefined) continue;
      const term = document.createElement("dt"), told = document.createElement("dd");
      term.textContent = name;
      told.textContent = power(String(text));
      list.append(term, told);
    }
    box.replaceChildren(list);
    box.style.display = "block";
    const gap = 14, wide = box.offsetWidth, high = box.offsetHeight;
    box.style.left = `${Math.max(6, Math.min(event.clientX + gap, innerWidth - wide - 6))}px`;
    box.style.top = `${event.clientY + gap + high > innerHeight ? Math.max(6, event.clientY - gap - high) : event.clientY + gap}px`;
  };

  window.addEventListener("scroll", () => (box.style.display = "none"), { passive: true });

  // The reason behind a cell, on hovering and for the keyboard on focus.
  for (const cell of document.querySelectorAll("[data-reason]")) {
    cell.setAttribute("aria-label", `${cell.textContent.trim()}. ${cell.dataset.reason}`);
    const show = (x, y) => hover(null, { clientX: x, clientY: y }, null, { "": cell.dataset.reason });
    cell.addEventListener("pointermove", (event) => show(event.clientX, event.clientY));
    cell.addEventListener("focus", () => {
      const place = cell.getBoundingClientRect();
      show(place.left, place.bottom);
    });
    for (const end of ["pointerleave", "blur"]) cell.addEventListener(end, () => (box.style.display = "none"));
  }

  // The reference engine is the yardstick; a reader may put it away on every page. The choice is kept where the browser lets us.
  const root = document.documentElement;
  const yardsticks = new Set(JSON.parse(root.dataset.yardsticks ?? "[]"));
  const away = () => root.dataset.yardstick === "hidden";
  const kept = (value) => {
    try {
      if (value !== undefined) localStorage.setItem("plumbline-yardstick", value);
      return localStorage.getItem("plumbline-yardstick");
    } catch {
      return null;
    }
  };
  // Columns whose heading names ours: every cell below, also where headings span several columns or rows.
  const columns = (table) => {
    const taken = [], own = new Set();
    [...(table.tHead?.rows ?? [])].forEach((row, line) => {
      let column = 0;
      for (const head of row.cells) {
        while (taken[line]?.[column]) column++;
        for (let down = 0; down < head.rowSpan; down++)
          for (let right = 0; right < head.colSpan; right++) (taken[line + down] ??= [])[column + right] = true;
        const mine = head.querySelector(".ours") !== null || (head.colSpan === 1 && own.has(column));
        for (let right = 0; right < head.colSpan; right++) if (mine) own.add(column + right);
        if (mine) head.classList.add("of-ours");
        column += head.colSpan;
      }
    });
    if (own.size) for (const body of table.tBodies) for (const row of body.rows)
      if (row.cells.length > 1) [...row.cells].forEach((cell, place) => own.has(place) && cell.classList.add("of-ours"));
  };
  document.querySelectorAll("table").forEach(columns);
  // What a chart draws: rows of ours go, and with them their places in scales and legends.
  const withoutYardstick = (part) => {
    if (Array.isArray(part)) return part.filter((row) => !(row && yardsticks.has(row.engine))).map(withoutYardstick);
    if (part === null || typeof part !== "object") return part;
    const left = Object.fromEntries(Object.entries(part).map(([name, value]) => [name, withoutYardstick(value)]));
    if (Array.isArray(left.domain) && left.domain.some((name) => yardsticks.has(name))) {
      const stays = left.domain.map((name) => !yardsticks.has(name));
      if (Array.isArray(left.range) && left.range.length === stays.length) left.range = left.range.filter((_, k) => stays[k]);
      left.domain = left.domain.filter((_, k) => stays[k]);
    }
    if (Array.isArray(left.sort)) left.sort = left.sort.filter((name) => !yardsticks.has(name));
    return left;
  };
  const put = (hidden) => {
    if (hidden) root.dataset.yardstick = "hidden";
    else delete root.dataset.yardstick;
  };
  put(kept() === "hidden");

  const refuse = { load: () => Promise.reject(new Error("no network")), sanitize: () => Promise.reject(new Error("no links")) };

  // What the legend of a chart can switch: engines by their colour and shape, tracks by the filling of their marks.
  const sides = (spec) => {
    const encodings = (spec.layer ?? [spec]).map((layer) => layer.encoding ?? {});
    const scale = (channel) => encodings.map((encoding) => encoding[channel]?.scale).find((one) => one?.domain?.length);
    const colours = scale("color"), shapes = scale("shape"), fillings = scale("fillOpacity");
    if (!colours) return [];
    const engines = colours.domain.map((name, k) => ({ field: "engine", name, names: [name], colour: colours.range[k], path: shapes?.range[k], filling: 1 }));
    // Tracks that are drawn alike are one switch: many settings beside the two have no look of their own.
    const looks = new Map();
    (fillings?.domain ?? []).forEach((name, k) => looks.set(fillings.range[k], [...(looks.get(fillings.range[k]) ?? []), name]));
    const tracks = [...looks].map(([filling, names]) => ({ field: "track", name: names.length > 1 ? "others" : names[0], names, filling }));
    return [...engines, ...(tracks.length > 1 ? tracks : [])];
  };
  const swatch = (side) => {
    const holder = document.createElement("template");
    holder.innerHTML = '<svg viewBox="-1.6 -1.6 3.2 3.2" aria-hidden="true"><path stroke-width=".32"/></svg>';
    const picture = holder.content.firstChild, path = picture.firstChild;
    path.setAttribute("d", side.path ?? "M1,0A1,1,0,1,1,-1,0A1,1,0,1,1,1,0Z");
    path.setAttribute("fill", side.colour ?? "currentColor");
    path.setAttribute("fill-opacity", side.filling);
    path.setAttribute("stroke", side.colour ?? "currentColor");
    return picture;
  };

  // Where the line is short, of a name of several words that ends in (ours) the first is left out, and long settings are cut.
  const part = (name, text) => {
    const span = document.createElement("span");
    span.className = name;
    span.textContent = text;
    return span;
  };
  const named = (side) => {
    const [, first, rest] = /^(\S+ )(.+ \(ours\))$/.exec(side.name) ?? [];
    if (side.field === "track" && side.name.length > 16) return [part("long", side.name)];
    if (!first) return [side.name];
    const whole = part("name", "");
    whole.append(part("more", first), rest);
    return [whole];
  };
  // One line of buttons above the chart; each leaves out what it names. The last engine and the last track stay.
  const legends = new WeakMap();
  const legend = (figure, spec) => {
    if (legends.has(figure)) return legends.get(figure);
    const left = new Set(), listed = sides(spec), strip = document.createElement("p");
    strip.className = "switches";
    for (const side of listed) {
      if (listed.filter((one) => one.field === side.field).length === 1) {
        const only = document.createElement("span");
        only.classList.toggle("of-ours", yardsticks.has(side.name));
        only.append(swatch(side), ...named(side));
        strip.append(only);
        continue;
      }
      const button = document.createElement("button");
      button.type = "button";
      button.setAttribute("aria-label", side.name);
      button.title = side.names.slice(0, 12).join(";\n");
      button.classList.toggle("of-ours", yardsticks.has(side.name));
      button.setAttribute("aria-pressed", "true");
      button.append(swatch(side), ...named(side));
      button.addEventListener("click", () => {
        const keys = (one) => one.names.map((name) => `${one.field} ${name}`), out = (one) => keys(one).every((key) => left.has(key));
        const shown = listed.filter((one) => one.field === side.field && !out(one));
        if (out(side)) for (const key of keys(side)) left.delete(key);
        else if (shown.length > 1) for (const key of keys(side)) left.add(key);
        button.setAttribute("aria-pressed", String(!out(side)));
        draw(figure);
      });
      strip.append(button);
    }
    if (listed.length) figure.querySelector(".plot").before(strip);
    legends.set(figure, left);
    return left;
  };
  const without = (values, left) =>
    left.size && Array.isArray(values) ? values.filter((row) => !left.has(`engine ${row.engine}`) && !left.has(`track ${row.track}`)) : values;

  // An en space: a line ends there, and what reads charts aloud finds a space.
  const BREAK = "\u2002";
  const broken = (title, room) => {
    if (title.length <= room) return title;
    const spaces = [...title].flatMap((sign, k) => (sign === " " ? [k] : [])), middle = title.length / 2;
    const at = spaces.sort((a, b) => Math.abs(a - middle) - Math.abs(b - middle))[0];
    return at === undefined ? title : `${title.slice(0, at)}${BREAK}${title.slice(at + 1)}`;
  };

  // The tables of a chart travel by columns and their words as places in a list, as `shown_spec` of reports/compact.py writes
  // them; a chart that shows the trials of one before it goes on with that one's list.
  const stored = (figure) => JSON.parse(figure.querySelector("script.spec").textContent);
  const words = ({ after, words: own }) => [...(after ? words(stored(document.getElementById(after))) : []), ...own];
  const rows = (table, list) => {
    if (Array.isArray(table)) return table;
    const fields = Object.entries(table.columns).map(([field, values]) => [field, Array.isArray(values) ? values : values.words.map((k) => list[k])]);
    return Array.from({ length: table.count }, (_, k) => Object.fromEntries(fields.map(([field, values]) => [field, values[k]])));
  };
  const specification = (figure) => {
    const { after, words: own, ...spec } = stored(figure), list = words({ after, words: own });
    for (const name of Object.keys(spec.datasets ?? {})) spec.datasets[name] = rows(spec.datasets[name], list);
    return spec;
  };

  const draw = async (figure) => {
    const whole = specification(figure);
    const spec = away() ? withoutYardstick(whole) : whole;
    const left = legend(figure, whole);
    for (const name of Object.keys(spec.datasets ?? {})) spec.datasets[name] = without(spec.datasets[name], left);
    // A layer that is left without a row has no extent to scale.
    if (spec.layer) spec.layer = spec.layer.filter((layer) => spec.datasets?.[layer.data?.name]?.length !== 0);
    spec.config = { ...scheme(), lineBreak: BREAK };
    // A title that is longer than its axis goes on in a second line.
    const rooms = { x: (figure.clientWidth - 120) / 7, y: (spec.height ?? 300) / 7 };
    for (const { encoding } of spec.layer ?? [spec]) {
      for (const [axis, room] of Object.entries(rooms)) if (typeof encoding?.[axis]?.title === "string") encoding[axis].title = broken(encoding[axis].title, room);
    }
    // On a phone names of cases leave room for the marks, and for the outcomes beside them.
    const outcomes = Object.values(spec.datasets ?? {}).flat().reduce((most, row) => Math.max(most, (row.column ?? -1) + 1), 0);
    const names = Math.max(90, figure.clientWidth - 150 - 13 * outcomes);
    for (const { encoding } of spec.layer ?? [spec]) {
      if (encoding?.y?.axis?.labelLimit > names) encoding.y.axis.labelLimit = names;
    }
    // The switches are the legend.
    for (const layer of sides(spec).length ? spec.layer ?? [spec] : []) {
      for (const channel of ["color", "stroke", "shape", "fillOpacity", "strokeDash"]) if (layer.encoding?.[channel]) layer.encoding[channel].legend = null;
    }
    figure.classList.add("live");
    try {
      // The interpreter (ast) stands in for compiled expressions, so the policy needs no eval.
      const made = await window.vegaEmbed(figure.querySelector(".plot"), spec, {
        mode: "vega-lite", renderer: "svg", actions: false, ast: true, defaultStyle: false, tooltip: hover, loader: refuse,
      });
      figure.dataset.drawn = "yes";
      made.view.addEventListener("click", (_, item) => {
        const row = item?.datum?.trial && document.getElementById(`trial-${item.datum.trial}`);
        if (row) location.hash = row.id;
      });
    } catch (error) {
      figure.classList.remove("live");
      console.error(error);
    }
  };
  // A chart in a closed fold has no width: it is drawn when the fold opens.
  const figures = [...document.querySelectorAll("figure.chart")];
  const drawn = (listed) => listed.reduce((before, figure) => before.then(() => draw(figure)), Promise.resolve());
  const open = () => figures.filter((figure) => figure.clientWidth > 0);
  if (window.vegaEmbed) {
    drawn(open());
    dark.addEventListener("change", () => drawn(open()));
    for (const fold of document.querySelectorAll("details")) {
      fold.addEventListener("toggle", () => drawn(open().filter((figure) => fold.contains(figure) && !figure.dataset.drawn)));
    }
  }

  // The switch stands where something of ours is drawn.
  const anyOfOurs = document.querySelector(".ours, .of-ours") ||
    figures.some((figure) => [...yardsticks].some((name) => figure.querySelector("script.spec").textContent.includes(JSON.stringify(name).slice(1, -1))));
  const top = document.querySelector(".top");
  if (yardsticks.size && anyOfOurs && top) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "yardstick";
    const say = () => {
      button.setAttribute("aria-pressed", String(away()));
      const verb = document.createElement("span");
      verb.textContent = away() ? "Show the " : "Hide the ";
      button.replaceChildren(verb, "reference engine");
      button.setAttribute("aria-label", `${verb.textContent}reference engine`);
    };
    button.title = "Plumbline's own engine is judged like the others, and no contestant";
    button.addEventListener("click", () => {
      put(!away());
      kept(away() ? "hidden" : "shown");
      say();
      for (const figure of figures) delete figure.dataset.drawn;
      if (window.vegaEmbed) drawn(open());
      document.dispatchEvent(new Event("yardstick"));
    });
    say();
    top.append(button);
  }

  // Where a server shows this page, it shows recordings too: a press on Watch opens one at its moment.
  if (location.protocol.startsWith("http") && location.pathname.startsWith("/report/")) {
    for (const watch of document.querySelectorAll("details.watch[data-view]")) {
      const link = document.createElement("a");
      link.className = "watch";
      link.href = watch.dataset.view;
      link.append(...watch.querySelector("summary").childNodes);
      watch.replaceWith(link);
    }
  }

  // What an address names inside of a fold, or as a fold, is open: from another page, and for a press on a link to it.
  const unfold = (hash) => {
    const named = hash.length > 1 && document.getElementById(decodeURIComponent(hash.slice(1)));
    if (!named) return;
    const before = named.closest("details:not([open])") !== null;
    for (let fold = named.closest("details"); fold; fold = fold.parentElement?.closest("details")) fold.open = true;
    if (before) named.scrollIntoView();
  };
  window.addEventListener("hashchange", () => unfold(location.hash));
  document.addEventListener("click", (event) => {
    const link = event.target.closest?.('a[href^="#"]');
    if (link) unfold(link.getAttribute("href"));
  });
  unfold(location.hash);

  // Tables: a click on a heading sorts; numbers by data-value, gaps always last.
  const key = (row, column) => {
    const cell = row.cells[column];
    const raw = cell.dataset.value ?? cell.textContent.trim();
    const number = raw === "" ? NaN : Number(raw);
    return { gap: raw === "" || raw === "–" || raw === "n/a", number, text: raw };
  };
  const compare = (a, b) =>
    Number.isNaN(a.number) || Number.isNaN(b.number) ? a.text.localeCompare(b.text, "en", { numeric: true }) : a.number - b.number;
  for (const table of document.querySelectorAll("table.sortable")) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const up = head.getAttribute("aria-sort") !== "ascending";
        heads.forEach((one) => one.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", up ? "ascending" : "descending");
        const body = table.tBodies[0];
        const rows = [...body.rows].map((row) => [key(row, column), row]);
        rows.sort(([a], [b]) => (a.gap !== b.gap ? a.gap - b.gap : a.gap ? 0 : up ? compare(a, b) : compare(b, a)));
        body.append(...rows.map(([, row]) => row));
      });
    });
  }

  // A search box and a choice of outcomes above each filterable table.
  for (const table of document.querySelectorAll("table.filterable")) {
    const rows = [...table.tBodies[0].rows].filter((row) => row.dataset.status);
    const frame = table.closest(".scroll");
    let tools = frame.previousElementSibling;
    if (!tools?.classList.contains("tools")) {
      tools = document.createElement("p");
      tools.className = "tools";
      frame.before(tools);
    }
    const search = document.createElement("input");
    search.type = "search";
    search.placeholder = "Filter by words";
    search.setAttribute("aria-label", "Filter the rows by words");
    const choice = document.createElement("select");
    choice.setAttribute("aria-label", "Show one kind of row");
    choice.append(new Option(table.dataset.all ?? "all outcomes", ""));
    for (const status of new Set(rows.map((row) => row.dataset.status))) choice.append(new Option(status, status));
    choice.value = table.dataset.first ?? "";
    const count = document.createElement("output");
    const apply = () => {
      const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      let shown = 0, all = 0;
      for (const row of rows) {
        const text = row.textContent.toLowerCase();
        const keep = (!choice.value || row.dataset.status === choice.value) && words.every((word) => text.includes(word));
        row.hidden = !keep;
        const of = !(away() && row.querySelector(".ours"));
        shown += keep && of;
        all += of;
      }
      count.textContent = `${shown} of ${all}`;
    };
    search.addEventListener("input", apply);
    choice.addEventListener("change", apply);
    document.addEventListener("yardstick", apply);
    tools.prepend(search, choice, count);
    apply();
    const reveal = () => {
      const row = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
      if (!row || !table.contains(row)) return;
      if (row.hidden) {
        search.value = choice.value = "";
        apply();
      }
      const more = row.querySelector("details");
      if (more) more.open = true;
      row.scrollIntoView({ block: "center" });
    };
    window.addEventListener("hashchange", reveal);
    reveal();
  }
})();
