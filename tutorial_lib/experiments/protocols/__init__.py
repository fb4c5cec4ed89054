"""Tasks, and how they are run."""
