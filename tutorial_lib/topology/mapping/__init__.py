"""The topological map: its vertices and edges, how it grows, and the files that hold it."""
