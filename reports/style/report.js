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
        titleFontWeight: 500, labelFontSize: 11, titleFontSize: 12,
      },
      legend: { labelColor: ink, titleColor: soft, titleFontWeight: 500, labelFontSize: 12 },
    };
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
      told.textContent = text;
      list.append(term, told);
    }
    box.replaceChildren(list);
    box.style.display = "block";
    const gap = 14, wide = box.offsetWidth, high = box.offsetHeight;
    box.style.left = `${Math.max(6, Math.min(event.clientX + gap, innerWidth - wide - 6))}px`;
    box.style.top = `${event.clientY + gap + high > innerHeight ? Math.max(6, event.clientY - gap - high) : event.clientY + gap}px`;
  };

  window.addEventListener("scroll", () => (box.style.display = "none"), { passive: true });

  const refuse = { load: () => Promise.reject(new Error("no network")), sanitize: () => Promise.reject(new Error("no links")) };

  const draw = async (figure) => {
    const spec = JSON.parse(figure.querySelector("script.spec").textContent);
    const small = figure.clientWidth < 480;
    const own = scheme();
    spec.config = { ...own, legend: { ...own.legend, ...(spec.config?.legend ?? {}), columns: small ? 1 : 3 } };
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
  const figures = [...document.querySelectorAll("figure.chart")];
  const drawAll = () => figures.reduce((before, figure) => before.then(() => draw(figure)), Promise.resolve());
  if (window.vegaEmbed) {
    drawAll();
    dark.addEventListener("change", drawAll);
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
    const tools = table.closest("section").querySelector(".tools");
    const search = document.createElement("input");
    search.type = "search";
    search.placeholder = "Filter, e.g. mujoco tuned";
    search.setAttribute("aria-label", "Filter the rows by words");
    const choice = document.createElement("select");
    choice.setAttribute("aria-label", "Show one kind of row");
    choice.append(new Option(table.dataset.all ?? "all outcomes", ""));
    for (const status of new Set(rows.map((row) => row.dataset.status))) choice.append(new Option(status, status));
    choice.value = table.dataset.first ?? "";
    const count = document.createElement("output");
    const apply = () => {
      const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      let shown = 0;
      for (const row of rows) {
        const text = row.textContent.toLowerCase();
        const keep = (!choice.value || row.dataset.status === choice.value) && words.every((word) => text.includes(word));
        row.hidden = !keep;
        shown += keep;
      }
      count.textContent = `${shown} of ${rows.length}`;
    };
    search.addEventListener("input", apply);
    choice.addEventListener("change", apply);
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
