// Creates elements of a page.

/** Creates an element with a text and properties. */
export function element(tag, textContent, properties = {}) {
  return Object.assign(document.createElement(tag), { textContent }, properties);
}
