// Create and fill elements; data from the network become text, never markup.

const SVG = "http://www.w3.org/2000/svg";

export const byId = (id) => document.getElementById(id);

export function element(tag, { text, ...attributes } = {}, ...children) {
  return filled(document.createElement(tag), text, attributes, children);
}

export function svg(tag, { text, ...attributes } = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), text, attributes, children);
}

// Escape what has no glyph, or changes the order of text; the joiners inside emoji stay.
const HIDDEN = /[\p{Cc}\p{Cf}\p{Zl}\p{Zp}\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u3164\ufe00-\ufe0d\uffa0\u{e0000}-\u{e0fff}]/gu;
const KEPT = /^[\n\t]$/;
const EMOJI = /^(\p{Extended_Pictographic}|\p{Emoji_Modifier}|\ufe0f)/u;

export function printable(text) {
  return String(text ?? "").replace(HIDDEN, (char, at, all) => {
    const before = [...all.slice(0, at)].at(-1) ?? "";
    const joins = char === "\u200d" && EMOJI.test(before) && EMOJI.test(all.slice(at + 1));
    return joins || KEPT.test(char) ? char : `\\u{${char.codePointAt(0).toString(16)}}`;
  });
}

function filled(node, text, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, printable(value));
  if (text !== undefined) node.textContent = printable(text);
  node.append(...children);
  return node;
}

// Set text only if it changes, to preserve selections and to avoid repeated announcements by screen readers.
export function setText(node, text) {
  const shown = printable(text);
  if (node.textContent !== shown) node.textContent = shown;
}

export function setClass(node, name, isSet) {
  node.classList.toggle(name, Boolean(isSet));
}

// Give a list one child per item, created on demand.
export function fill(list, items, make, update) {
  while (list.children.length > items.length) list.lastElementChild.remove();
  items.forEach((item, index) => {
    if (index >= list.children.length) list.append(make(item));
    update(list.children[index], item);
  });
}
