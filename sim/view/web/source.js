// Receives frames of finished runs over HTTP, and of a live run over a WebSocket.

const token = new URLSearchParams(location.search).get('token') ?? '';
const address = (path) => `.${path}?token=${encodeURIComponent(token)}`;

async function get(path) {
  const response = await fetch(address(path));
  if (!response.ok) throw new Error(`${path}: ${(await response.text()).trim()}`);
  return response;
}
export const pause = (ms) =>
  new Promise((resolve) => {
    setTimeout(resolve, ms);
  });
export const getJson = async (path) => (await get(path)).json();
export const getBytes = async (path) => (await get(path)).arrayBuffer();
export const getBlob = async (path) => (await get(path)).blob();

/// Returns the JSON at the start of a buffer from the program (after its length) and the offset of its
/// end.
export function withLength(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  return [JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))), 4 + length];
}

export const picture = (blob) => createImageBitmap(blob);

/// Fetches the elements of a server list by number and keeps the last few. read: converts the bytes to an
/// element.
export class Stored {
  constructor(folder, read, most) {
    Object.assign(this, {folder, read, most, kept: new Map()});
  }

  at(number) {
    let element = this.kept.get(number);
    if (!element) {
      element = getBlob(`${this.folder}/${number}`).then((blob) => (blob.size > 0 ? this.read(blob) : null));
      this.kept.set(number, element);
      if (this.kept.size > this.most) this.kept.delete(this.kept.keys().next().value);
    }
    return element;
  }
}

/// Calls frame(JSON, bytes of the image), message(JSON) and closed() as they arrive.
export function listen({frame, message: received, closed}) {
  const socket = new WebSocket(
    new URL(address('/socket'), location.href.replace(/^http/, 'ws')),
    'gaitslam.view.v1'
  );
  socket.binaryType = 'arraybuffer';
  socket.onmessage = ({data}) => {
    if (typeof data === 'string') return received(JSON.parse(data));
    const [content, end] = withLength(data);
    frame(content, new Uint8Array(data, end));
  };
  socket.onclose = closed;
  const opened = new Promise((resolve) => {
    socket.onopen = resolve;
  });
  return (message) =>
    opened.then(() => {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
    });
}
