// The time in the page's URL, after '#'.

const kLeast_ms = 250; // browsers ignore more frequent changes

/// NaN without a time.
export const timeInAddress = () => parseFloat(new URLSearchParams(location.hash.slice(1)).get('t'));

/// Returns a function that soon writes what time() returns at that time.
export function addressWriter(time) {
  let timer = null;
  const write = () => {
    timer = null;
    history.replaceState(null, '', `#t=${time().toFixed(2)}`);
  };
  return () => {
    timer ??= setTimeout(write, kLeast_ms);
  };
}
