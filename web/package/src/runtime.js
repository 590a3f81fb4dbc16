// Exports what all modules of the package share: messages, workers, the error. Not part of the public interface.

export { NeuralMeshError } from './error.js';
export { makeProgram } from './program.js';
