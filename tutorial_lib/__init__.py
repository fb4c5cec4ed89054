"""A small library behind a course on topological visual navigation.

It reads from the ground up: `geometry` and `interfaces`, then `world`, `driving` and so on; each
package imports only from those below it (``tests/test_layers.py`` enforces the order).
"""
