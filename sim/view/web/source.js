// Frames of finished runs over HTTP, and of a live run over a WebSocket.

const token = new URLSearchParams(location.search).get('token') ?? '';
const address = (path) => `${path}?token=${encodeURIComponent(token)}`;

async function get(path) {
  const response = await fetch(address(path));
  if (!response.ok) throw new Error(`${path}: ${(await response.text()).trim()}`);
  return response;
}
export const getJson = async (path) => (await get(path)).json();
export const getBytes = async (path) => (await get(path)).arrayBuffer();

const kKept = 400;

/// Images by the index of their frame; keeps the last few hundred.
export class StoredImages {
  constructor(run) { Object.assign(this, {run, kept: new Map()}); }

  at(index) {
    if (!this.run.frames[index]?.stored_image) return Promise.resolve(null);
    let image = this.kept.get(index);
    if (!image) {
      image = get(`/image/${this.run.index}/${index}`).then((response) => response.blob()).then((blob) => createImageBitmap(blob));
      this.kept.set(index, image);
      if (this.kept.size > kKept) this.kept.delete(this.kept.keys().next().value);
    }
    return image;
  }
}

/// Calls frame(JSON, bytes of the image), message(JSON) and closed() as they arrive.
export function listen({frame, message: received, closed}) {
  const socket = new WebSocket(`ws://${location.host}${address('/socket')}`, 'gaitslam.view.v1');
  socket.binaryType = 'arraybuffer';
  socket.onmessage = ({data}) => {
    if (typeof data === 'string') return received(JSON.parse(data));
    const length = new DataView(data).getUint32(0, true);
    frame(JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length))), new Uint8Array(data, 4 + length));
  };
  socket.onclose = closed;
  const opened = new Promise((resolve) => { socket.onopen = resolve; });
  return (message) => opened.then(() => { if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); });
}
