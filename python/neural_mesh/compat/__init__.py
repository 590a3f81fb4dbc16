"""Other packages' functions by their names and with their meaning, so that a pipeline changes one import."""
