"""Output of notebook cells: widgets, films, and driving by hand."""
