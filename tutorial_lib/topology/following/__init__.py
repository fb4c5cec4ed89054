"""Following a path of anchors by sight (Meng 2020, III-H)."""
