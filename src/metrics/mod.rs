//! How far a simplified mesh is from its original; the judge, which knows no method.
