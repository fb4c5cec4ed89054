"""The page of results, made from the stored reports: `tutorial_lib/results/README.md`."""
