// A flight: the camera moves away from where it is and comes back, so that levels change.

import { zoom } from './view.js';

/** Milliseconds of a flight. */
const DURATION = 9000;
/** Largest distance of a flight, over that of its beginning. */
const FARTHEST = 10;

/**
 * Makes a button start and end flights of a view. `begin()` is called before a flight; what it returns gets the distance over that of the
 * beginning after each step.
 */
export function wireFlight(view, button, begin = () => () => {}) {
  const flight = { began: null, distance: 0, follow: null };
  const end = () => {
    flight.began = null;
    button.setAttribute('aria-pressed', 'false');
  };
  const step = (now) => {
    // A reader who takes the camera, or starts over, ends the flight.
    if (flight.began === null || !view.isMoved) return end();
    const share = Math.min(Math.max((now - flight.began) / DURATION, 0), 1);
    const factor = FARTHEST ** (Math.sin(Math.PI * share) ** 2);
    // The controls bound distances, so each step is from where the camera is.
    zoom(view, (factor * flight.distance) / distanceOf(view));
    flight.follow(factor);
    return share < 1 ? requestAnimationFrame(step) : end();
  };
  button.addEventListener('click', () => {
    if (flight.began !== null) return end();
    Object.assign(flight, { began: performance.now(), distance: distanceOf(view), follow: begin() });
    button.setAttribute('aria-pressed', 'true');
    view.isMoved = true;
    return requestAnimationFrame(step);
  });
  view.controls.addEventListener('start', end);
}

function distanceOf({ camera, controls }) {
  return camera.position.distanceTo(controls.target);
}
