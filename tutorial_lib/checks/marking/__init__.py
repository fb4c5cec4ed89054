"""Marks the answers that students handed in: each in a process of its own, apart from its check."""
