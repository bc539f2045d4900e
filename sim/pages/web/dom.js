// Creates an element from a tag, attributes and children. Text is always inserted as text.
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (value !== null && value !== false) node.setAttribute(name, value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

/// A button that does not keep the keyboard focus after a mouse click. action: gets the button.
export function button(text, title, action, attributes = {}) {
  const onclick = ({currentTarget, detail}) => {
    action(currentTarget);
    if (detail > 0) currentTarget.blur();
  };
  return element('button', {type: 'button', title, ...attributes, onclick}, text);
}

/// A choice that does not keep the keyboard focus. options: values with their texts. choose: gets the chosen
/// value.
export function choice(title, options, choose, attributes = {}) {
  const onchange = ({currentTarget}) => {
    choose(currentTarget.value);
    currentTarget.blur();
  };
  return element(
    'select',
    {title, ...attributes, onchange},
    options.map(([value, text]) => element('option', {value}, text))
  );
}

export const color = (role) =>
  getComputedStyle(document.documentElement)
    .getPropertyValue('--' + role)
    .trim();

/// Makes a table sortable: a click on a title sorts the rows by that column, numbers before texts; another
/// click reverses the order.
export function sortable(table) {
  const body = table.tBodies[0],
    titles = [...table.tHead.rows[0].cells];
  const key = (row, column) => {
    const {dataset, textContent} = row.cells[column] ?? {};
    return dataset?.value ?? textContent?.trim() ?? '';
  };
  const compare = (a, b) => {
    const [p, q] = [parseFloat(a), parseFloat(b)];
    return Number.isNaN(p) - Number.isNaN(q) || p - q || a.localeCompare(b);
  };
  titles.forEach((title, column) => {
    const text = [...title.childNodes];
    const sort = () => {
      const turn = title.ariaSort === 'ascending' ? -1 : 1;
      for (const other of titles) other.removeAttribute('aria-sort');
      title.setAttribute('aria-sort', turn > 0 ? 'ascending' : 'descending');
      body.append(...[...body.rows].sort((a, b) => turn * compare(key(a, column), key(b, column))));
    };
    title.append(button(text, 'sort by this column', sort, {class: 'sort'}));
  });
}
