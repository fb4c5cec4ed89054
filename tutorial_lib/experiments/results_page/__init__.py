"""The results page, made from the stored reports: `tutorial_lib/results/README.md`."""
