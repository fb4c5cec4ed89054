"""The commands of the command line, a file each; only the one that is asked for is imported."""
