// The error of everything in this package that is not an argument of the wrong type.

/** An error whose message is one line: what is wrong, where, and what to do. */
export class NeuralMeshError extends Error {
  name = 'NeuralMeshError';
}
