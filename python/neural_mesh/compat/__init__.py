"""Replacements for functions of other packages, with their names and signatures, so that a pipeline changes one import."""
