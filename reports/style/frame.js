// What stands around the content: a menu on a phone, what a wide table hides, folds that open for what is linked in them.
"use strict";

(() => {
  // The menu: without this script the links wrap.
  const top = document.querySelector(".top"), nav = top?.querySelector("nav");
  if (nav) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "menu";
    button.textContent = "Menu";
    nav.id = "pages";
    button.setAttribute("aria-controls", nav.id);
    const turn = (open) => {
      button.setAttribute("aria-expanded", String(open));
      top.classList.toggle("folded", !open);
    };
    button.addEventListener("click", () => turn(top.classList.contains("folded")));
    nav.addEventListener("click", () => turn(false));
    top.addEventListener("keydown", (event) => event.key === "Escape" && (turn(false), button.focus()));
    nav.before(button);
    turn(false);
  }

  // A link to what lies in a closed fold opens it.
  const unfold = () => {
    const place = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!place) return;
    for (let fold = place.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
    place.scrollIntoView();
  };
  window.addEventListener("hashchange", unfold);
  unfold();

  // A table that is wider than its frame names the columns out of sight, and its frame can be scrolled by keyboard.
  const heading = (head) => head.innerText.replace(/\s+/g, " ").trim().replace(/ ours$/, "");
  const tell = (frame, hint) => {
    const over = frame.scrollWidth - frame.clientWidth > 1 || frame.scrollHeight - frame.clientHeight > 1;
    if (over) frame.tabIndex = 0;
    else frame.removeAttribute("tabindex");
    const edge = frame.getBoundingClientRect().right, row = frame.querySelector("thead tr");
    const hidden = row ? [...row.cells].filter((head) => head.getBoundingClientRect().right > edge + 12) : [];
    const names = hidden.map(heading).filter(Boolean);
    hint.hidden = names.length === 0;
    hint.textContent = `Farther right: ${names.slice(0, 6).join(", ")}${names.length > 6 ? ` and ${names.length - 6} more` : ""} \u2192`;
    frame.classList.toggle("cut", names.length > 0);
  };
  const watcher = window.ResizeObserver && new ResizeObserver((seen) => seen.forEach(({ target }) => target.closest(".scroll").dispatchEvent(new Event("scroll"))));
  for (const frame of document.querySelectorAll(".scroll")) {
    const hint = document.createElement("p");
    hint.className = "beyond";
    hint.hidden = true;
    frame.after(hint);
    if (!frame.hasAttribute("aria-label")) {
      frame.setAttribute("role", "region");
      const named = frame.closest("figure, details, section, article")?.querySelector("h2, h3, summary");
      frame.setAttribute("aria-label", `Table: ${named ? named.textContent.trim() : document.title}`);
    }
    frame.addEventListener("scroll", () => tell(frame, hint), { passive: true });
    for (const one of [frame, ...frame.children]) watcher?.observe(one);
    tell(frame, hint);
  }
})();
