"""Lifelong Topological Visual Navigation: its label, its model, its maps, and how they mend."""
