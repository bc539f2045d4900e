// Elements from a tag, attributes and children.
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (value !== null && value !== false) node.setAttribute(name, value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

export function section(id, title, ...children) {
  return element('section', {id}, element('h2', {}, title), ...children);
}

/// What may be wider than the page: scrolled by keyboard too.
export const scroll = (what, child) =>
  element('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': what}, child);

export const color = (role) => getComputedStyle(document.documentElement).getPropertyValue('--' + role).trim();

export function number(value) {
  if (value === null || value === undefined) return '–';
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e6) return String(value);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2) : value.toPrecision(4).replace(/\.?0+$/, '');
}

const kSuperscripts = {'-': '⁻', 0: '⁰', 1: '¹', 2: '²', 3: '³', 4: '⁴', 5: '⁵', 6: '⁶', 7: '⁷', 8: '⁸', 9: '⁹'};

/// A tick's value in few digits; below 0.001 and from 100 000 on by a power of ten, as in 5·10⁻⁴.
export function tick(value) {
  const size = Math.abs(value);
  if (size < 1e-12) return '0';
  if (size >= 0.99e-3 && size < 1e5) return String(+value.toPrecision(4));
  const [digits, exponent] = value.toExponential(2).split('e');
  const power = '10' + [...String(+exponent)].map((c) => kSuperscripts[c]).join('');
  return +digits === 1 ? power : `${+digits}·${power}`;
}

export function copyable(text) {
  const button = element('button', {type: 'button', class: 'no-print', onclick: () => {
    navigator.clipboard?.writeText(text).then(() => { button.textContent = 'copied'; });
  }}, 'copy');
  return element('div', {}, element('pre', {}, text), button);
}

/// How many figures the page has and how many of them are drawn, for whoever tests the page.
function count(name) {
  const {dataset} = document.documentElement;
  dataset[name] = Number(dataset[name] ?? 0) + 1;
}
export const countExpected = () => count('figures');
export const countDrawn = () => count('drawn');
