"""Pictures and films: pure functions from state to arrays, one visual language for all."""
