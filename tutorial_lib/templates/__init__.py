"""Classes to begin one's own with, a file for each thing that a class can be."""
