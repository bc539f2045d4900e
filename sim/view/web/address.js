// The part of the page's URL after '#': time, view, hidden layers and figures, zoom, images and landmark.

const kLeast_ms = 250; // browsers ignore more frequent changes

/// The contents of the URL. t: NaN if it has no time; strips: hidden figures, null if not stated.
export function readAddress() {
  const values = new URLSearchParams(location.hash.slice(1));
  const list = (name) => (values.get(name) ?? '').split(',').filter(Boolean);
  const zoom = list('zoom').map(Number);
  const [run, id] = (values.get('pick') ?? '').split('.').map(Number);
  return {
    t: parseFloat(values.get('t')),
    view: values.get('view'),
    hide: list('hide'),
    show: list('show'),
    strips: values.has('t') ? list('strips') : null,
    split: values.has('split'),
    image: values.get('image'),
    pick: Number.isInteger(id) ? {run, id} : null,
    zoom: zoom.length === 2 && zoom[0] < zoom[1] ? zoom : null
  };
}

/// Writes the values to the URL; omits empty ones.
export function writeAddress(values) {
  const parts = Object.entries(values).filter(([, value]) => value);
  history.replaceState(null, '', `#${parts.map(([name, value]) => `${name}=${value}`).join('&')}`);
}

/// Returns a function that writes the result of values() to the URL after a short delay.
export function addressWriter(values) {
  let timer = null;
  const write = () => {
    timer = null;
    writeAddress(values());
  };
  return () => {
    timer ??= setTimeout(write, kLeast_ms);
  };
}
