// What can be seen to be wrong with an open page, in words, and its height.
() => {
  const wide = document.documentElement.clientWidth, found = [];
  const shown = (one) => one.checkVisibility({ visibilityProperty: true });
  if (document.documentElement.scrollWidth > wide) {
    const over = [...document.querySelectorAll("main *, header *, footer *")]
      .filter((one) => shown(one) && !one.closest(".scroll *") && one.getBoundingClientRect().right > wide + 1);
    found.push(`scrolls sideways: ${document.documentElement.scrollWidth} of ${wide} px, ${over.slice(0, 3).map((one) => `${one.tagName}.${one.className}`)}`);
  }
  for (const figure of document.querySelectorAll("figure.chart")) {
    if (!shown(figure)) continue;
    const svg = figure.querySelector(".plot svg.marks");
    if (!svg) { found.push(`${figure.id}: no chart`); continue; }
    const marks = svg.querySelectorAll(".mark-symbol path, .mark-line path, .mark-rule line, .mark-rect path, .mark-area path, .mark-text text");
    const drawn = [...marks].filter((mark) => !mark.closest(".role-axis, .role-legend"));
    if (!drawn.length) found.push(`${figure.id}: no marks`);
    const frame = svg.getBoundingClientRect();
    if (frame.right > figure.getBoundingClientRect().right + 1) found.push(`${figure.id}: wider than its card`);
    for (const text of svg.querySelectorAll(".role-axis text, .role-axis-title text, .role-title text")) {
      const box = text.getBoundingClientRect();
      if (box.width && (box.left < frame.left - 2 || box.right > frame.right + 2 || box.top < frame.top - 2 || box.bottom > frame.bottom + 2))
        found.push(`${figure.id}: '${text.textContent}' is cut off`);
    }
    const keys = figure.querySelector(".switches");
    if (!keys?.children.length) { if (figure.querySelector("script.spec").textContent.includes('"engine"')) found.push(`${figure.id}: no legend`); }
    else {
      if (keys.scrollWidth > keys.clientWidth + 1) found.push(`${figure.id}: its legend does not fit`);
      const cut = [...keys.querySelectorAll("*")].find((one) => wide < 500 && one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).overflow === "hidden");
      if (cut) found.push(`${figure.id}: its legend cuts '${cut.textContent}'`);
      if (svg.querySelector(".role-legend *")) found.push(`${figure.id}: two legends`);
    }
    const caption = figure.querySelector(".caption"), line = parseFloat(getComputedStyle(caption).lineHeight);
    if (wide > 1000 && caption.getBoundingClientRect().height > 2.3 * line) found.push(`${figure.id}: a caption of more than two lines`);
  }
  for (const frame of document.querySelectorAll(".scroll")) {
    if (!shown(frame) || frame.scrollWidth <= frame.clientWidth + 1) continue;
    if (frame.tabIndex !== 0) found.push(`a wide table without a keyboard: ${frame.getAttribute("aria-label")}`);
    const heads = frame.querySelector("thead tr")?.cells ?? [], edge = frame.getBoundingClientRect().right + 12;
    if ([...heads].some((head) => head.textContent.trim() && head.getBoundingClientRect().right > edge) && frame.nextElementSibling?.hidden !== false)
      found.push(`a wide table that hides columns in silence: ${frame.getAttribute("aria-label")}`);
  }
  for (const one of document.querySelectorAll("a[href], button, input, select, summary, textarea"))
    if (shown(one) && one.tabIndex < 0) found.push(`out of reach of the keyboard: ${one.outerHTML.slice(0, 80)}`);
  for (const fold of document.querySelectorAll("details")) if (!fold.querySelector(":scope > summary")?.textContent.trim()) found.push("a fold without a name");
  for (const text of document.querySelectorAll("p.note, p.caption, li"))
    if (/\d[eE][-+]?\d/.test(text.innerText.replace(/<[^>]*>/g, "")) && !text.querySelector("code")) found.push(`a power in another notation: ${text.innerText.slice(0, 80)}`);
  return { found, high: document.documentElement.scrollHeight };
}
