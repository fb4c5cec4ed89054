"""From drives to a map of anchors, and back to driving: sparsify, follow."""
