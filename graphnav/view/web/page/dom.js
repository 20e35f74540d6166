// Make and fill elements; whatever comes over the network becomes text, never markup.

const SVG = "http://www.w3.org/2000/svg";

export const byId = (id) => document.getElementById(id);

export function element(tag, { text, ...attributes } = {}, ...children) {
  return filled(document.createElement(tag), text, attributes, children);
}

export function svg(tag, { text, ...attributes } = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), text, attributes, children);
}

function filled(node, text, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  node.append(...children);
  return node;
}

// Set text only where it changes: what is selected stays selected, what is read aloud is read once.
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function setClass(node, name, isSet) {
  node.classList.toggle(name, Boolean(isSet));
}

// Let a list have one child for each item, made when it is first needed.
export function fill(list, items, make, update) {
  while (list.children.length > items.length) list.lastElementChild.remove();
  items.forEach((item, index) => {
    if (index >= list.children.length) list.append(make(item));
    update(list.children[index], item);
  });
}
