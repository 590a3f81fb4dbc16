// What all modules of the package share, once: messages, workers, the error. Not part of the interface.

export { NeuralMeshError } from './error.js';
export { makeProgram } from './program.js';
