// The headline over the meshes: what became of the mesh, in three parts that a reader can repeat.

import { element } from './element.js';
import { headline } from './verdicts.js';

/** Fills the headline for a result; both are {bytes, faces, values}, `values` of the result may be missing while they are measured. */
export function fillHeadline(box, original, result) {
  const parts = headline({ original, result }).map(({ value, words, grade }) => {
    const part = element('p', '', { className: `part ${grade}` });
    part.append(element('strong', value), element('span', words));
    return part;
  });
  box.replaceChildren(...parts);
}
