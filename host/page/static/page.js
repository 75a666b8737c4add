// Chooses between the viewer on WebGPU and CPU rendering in a worker.
// `window.relievo` is for tests and other programs: probe() returns the state.

const notice = document.getElementById("notice");
const start = performance.now();
window.relievo = { probe: () => ({ settled: false }), error: null };

function fail(error, what = "start") {
  window.relievo.error = String(error);
  notice.hidden = false;
  notice.textContent = `Relievo cannot ${what}: ${error}`;
}

async function hasWebGpu() {
  if (new URLSearchParams(location.search).has("cpu")) return false;
  return Boolean(navigator.gpu && (await navigator.gpu.requestAdapter()));
}

async function withGpu() {
  const { default: load, GpuPage } = await import("./relievo_page.js");
  await load();
  const page = new GpuPage();
  const canvas = document.getElementById("viewer");
  canvas.hidden = false;
  const problem = await page.start(canvas, location.hash);
  notice.textContent = problem ?? "";
  notice.hidden = !problem;
  window.relievo.probe = () => {
    const told = page.probe();
    return told ? JSON.parse(told) : { settled: false };
  };
}

function withCpu() {
  let reason = "This browser has no WebGPU: pictures are drawn by the CPU, and slowly.";
  notice.textContent = reason;
  document.getElementById("fallback").hidden = false;
  // The worker reads the scene of the address.
  const worker = new Worker(`worker.js${location.hash}`, { type: "module" });
  const canvas = document.getElementById("picture");
  const context = canvas.getContext("2d");
  const state = { settled: false, renderer: "CPU", frames: 0, message: "" };
  window.relievo.probe = () => state;
  // One picture at a time: requests are queued meanwhile.
  let busy = true;
  let wanted = [];
  let moved = 0;
  const ask = (...orders) => {
    wanted.push(...orders);
    moved = performance.now();
    state.settled = false;
    send();
  };
  const send = (coarse = true) => {
    if (busy) return;
    busy = true;
    const factor = coarse ? 4 : 1;
    const size = [canvas.width / factor, canvas.height / factor].map(Math.round);
    worker.postMessage({ orders: wanted, size, coarse });
    wanted = [];
  };
  worker.onerror = (event) => fail(event.message, "go on");
  worker.onmessage = async ({ data }) => {
    if (data.scene !== undefined) return download("relievo.toml", new Blob([data.scene]));
    if (data.link !== undefined) return copy(data.link);
    busy = false;
    if (data.ready) {
      reason = data.problem ?? reason;
      for (const [name, value] of data.values) {
        const input = document.querySelector(`[name=${name}]`);
        if (input.type === "checkbox") input.checked = value > 0;
        else input.value = value;
        if (input.type === "range") input.nextElementSibling.textContent = input.value;
      }
      return send();
    }
    state.message = data.error ?? "";
    notice.textContent = data.error ?? reason;
    if (data.error) {
      // Keep what is shown; the next change may be better.
      if (wanted.length) send();
      return;
    }
    const [width, height] = data.size;
    const picture = await createImageBitmap(new ImageData(data.pixels, width, height));
    context.drawImage(picture, 0, 0, canvas.width, canvas.height);
    state.frames += 1;
    state.first_picture_ms ??= performance.now() - start;
    if (wanted.length) send();
    else if (data.coarse) setTimeout(() => wanted.length || send(false), Math.max(0, 150 - (performance.now() - moved)));
    else state.settled = !busy;
  };
  document.getElementById("controls").addEventListener("submit", (event) => event.preventDefault());
  for (const input of document.querySelectorAll("#controls input[name]")) {
    if (input.type === "range") {
      const output = document.createElement("output");
      const tell = () => (output.textContent = input.value);
      input.after(output);
      input.addEventListener("input", tell);
      tell();
    }
    input.addEventListener("input", () =>
      ask({ set: [input.name, input.type === "checkbox" ? Number(input.checked) : Number(input.value)] }));
  }
  document.getElementById("show").addEventListener("change", (event) => ask({ show: event.target.value }));
  document.getElementById("letters").addEventListener("input", (event) => {
    if (event.target.value.trim()) ask({ letters: event.target.value });
  });
  const adopt = async (file) => ask({ adopt: [file.name, new Uint8Array(await file.arrayBuffer())] });
  document.getElementById("file").addEventListener("change", (event) => [...event.target.files].forEach(adopt));
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    [...event.dataTransfer.files].forEach(adopt);
  });
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    const [x, y] = [event.movementX, event.movementY].map((pixels) => pixels / canvas.clientHeight);
    if (event.shiftKey || event.buttons > 1) ask({ turn: [0, 0, -x, y, 1] });
    else ask({ turn: [-Math.PI * x, Math.PI * y, 0, 0, 1] });
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    ask({ turn: [0, 0, 0, 0, Math.exp(-event.deltaY * 0.002)] });
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const turns = {
      ArrowRight: [0.1, 0, 0, 0, 1], ArrowLeft: [-0.1, 0, 0, 0, 1],
      ArrowUp: [0, 0.1, 0, 0, 1], ArrowDown: [0, -0.1, 0, 0, 1],
      "+": [0, 0, 0, 0, 1.1], "-": [0, 0, 0, 0, 1 / 1.1],
    };
    if (!turns[event.key]) return;
    event.preventDefault();
    ask({ turn: turns[event.key] });
  });
  document.getElementById("save-picture").addEventListener("click", () =>
    canvas.toBlob((blob) => download("relievo.png", blob)));
  document.getElementById("save-scene").addEventListener("click", () => worker.postMessage({ scene: true }));
  document.getElementById("copy-link").addEventListener("click", () => worker.postMessage({ link: true }));
  async function copy(fragment) {
    history.replaceState(null, "", `#${fragment}`);
    await navigator.clipboard?.writeText(location.href).catch(() => null);
    notice.textContent = "The link is copied, and is in the address bar.";
  }
}

// A link may be opened in this very page. Copying one changes the address without this event.
addEventListener("hashchange", () => location.reload());

function download(name, blob) {
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(blob);
  anchor.download = name;
  anchor.click();
  // The browser may start reading a moment later.
  setTimeout(() => URL.revokeObjectURL(anchor.href), 60_000);
}

try {
  if (await hasWebGpu()) await withGpu();
  else withCpu();
} catch (error) {
  fail(error);
}
