"""What goes wrong: disturbances, faults, unsound plans."""
