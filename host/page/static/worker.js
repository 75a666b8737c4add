// Renders on the CPU, off the page's thread.
import load, { CpuPage } from "./relievo_page.js";

await load();
const page = new CpuPage(location.hash);
postMessage({ ready: true, problem: page.problem(), values: JSON.parse(page.values()) });

onmessage = ({ data }) => {
  if (data.scene) return postMessage({ scene: page.scene() });
  try {
    if (data.link) return postMessage({ link: page.link() });
    for (const order of data.orders) {
      if (order.set) page.set(...order.set);
      if (order.show) page.show(order.show);
      if (order.letters) page.letter(order.letters);
      if (order.turn) page.turn(...order.turn);
      if (order.adopt) page.adopt(...order.adopt);
    }
    const pixels = new Uint8ClampedArray(page.render(...data.size));
    postMessage({ pixels, size: data.size, coarse: data.coarse }, [pixels.buffer]);
  } catch (error) {
    postMessage({ error: String(error) });
  }
};
