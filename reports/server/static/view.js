// Starts rerun's web viewer on the recording that the address names, which must lie on this server.
"use strict";

const state = document.getElementById("state");
const say = (text) => { state.hidden = !text; state.textContent = text; };

function recording() {
  const asked = new URL(new URLSearchParams(location.search).get("recording") || "", location.origin);
  if (asked.origin !== location.origin || !asked.pathname.startsWith("/recordings/")) {
    throw new Error("the address names no recording of this server");
  }
  const at = new URLSearchParams(location.search).get("at");
  // Of a moment [s] the server makes a recording of its own.
  if (at !== null && /^\d{1,9}(\.\d{1,12})?$/.test(at)) asked.pathname = `/moment/${at}/${asked.pathname.split("/").pop()}`;
  return asked.href;
}

// The viewer would report its use to its makers. The content policy stops that with an error; this answers before it is asked.
const ask = window.fetch.bind(window);
window.fetch = (resource, ...rest) => {
  const { origin } = new URL(resource instanceof Request ? resource.url : resource, location.href);
  return origin === location.origin ? ask(resource, ...rest) : Promise.resolve(new Response(null, { status: 204 }));
};

async function start() {
  const url = recording();
  const program = await fetch("/viewer/re_viewer_bg.wasm");
  if (!program.ok) throw new Error(await program.text());
  await wasm_bindgen({ module_or_path: program });
  const viewer = new wasm_bindgen.WebHandle({
    url: [url],
    hide_welcome_screen: true,
    enable_history: false,
    persist: false,
    notebook: false,
    render_backend: new URLSearchParams(location.search).get("renderer"),
  });
  await viewer.start(document.getElementById("viewer"));
  say("");
  setInterval(() => { if (viewer.has_panicked()) say(`The viewer has stopped: ${viewer.panic_message()}`); }, 2000);
}

start().catch((error) => say(`The viewer did not start: ${error.message || error}`));
