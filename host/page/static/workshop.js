// Prepares and analyses the scenes of the viewer, off the page's thread. The first message is the
// page's WebAssembly module, each other one an order.
import load, { Station } from "./relievo_page.js";

let station;

async function answer(data) {
  if (!station) {
    station = load({ module_or_path: data }).then(() => new Station());
    await station;
    postMessage("ready");
    return;
  }
  const delivery = (await station).work(data);
  postMessage(delivery, [delivery.buffer]);
}

onmessage = ({ data }) => answer(data).catch((error) => postMessage({ error: String(error) }));
