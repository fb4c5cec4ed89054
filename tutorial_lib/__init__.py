"""A small library behind a course on topological visual navigation.

It reads from the ground up: `geometry` and `interfaces`, then `world`, `driving` and so on; each
package imports only from those below it (``tests/project/test_layers.py`` enforces the order).
"""

__version__ = "0.3.0"
