// Defines the error of the program, for everything except arguments of a wrong type.

/** An error with a one-line message that says what is wrong, where, and what to do. */
export class NeuralMeshError extends Error {
  name = 'NeuralMeshError';
}
