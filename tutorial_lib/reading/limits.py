"""How large what is read may be, and why: a laptop must survive any file within a few seconds."""

KILOBYTE, MEGABYTE = 1_000, 1_000_000

MAX_JSON = 16 * MEGABYTE
"""Bytes of a JSON document. Python needs up to 30 times as many for it, half a gigabyte. A map of
10,000 vertices and 100,000 edges has 4 MB."""
MAX_DEPTH = 32
"""Lists and mappings within each other. Ours have 6 at most, and Python's own recursion ends
somewhere below 1,000."""
MAX_YAML = 64 * KILOBYTE
"""Bytes of a YAML document. A ROS map's has 200, and the parser takes 10 µs for each."""
MAX_TEXT = 4 * MEGABYTE
"""Bytes of any other text: an answer, a page, the source of a notebook."""
MAX_NOTEBOOK = 64 * MEGABYTE
"""Bytes of a notebook, whose pictures are text; ours have 1 MB at most."""
MAX_PIXELS = 4_096**2
"""Of a picture, and cells of the grid that a floor plan needs. 4,096 cells of 5 cm are 205 m; ROS's
gmapping saves 4,000 x 4,000. Distances to walls take 30 bytes a cell, half a gigabyte."""
MAX_PLAIN_PIXELS = 2_000_000
"""Of a PGM whose pixels are text (P2), each of which is 40 bytes in Python; a third in colour."""
MAX_PICTURE = 160 * MEGABYTE
"""Bytes of a picture's file: so many pixels, each four numbers of 16 bits, not compressed."""
MAX_ARRAYS = 512 * MEGABYTE
"""Bytes of all arrays of an `.npz` file, unpacked. A map of 10,000 vertices has 400 MB, and a
million recorded frames have 470 MB."""
MAX_MEMBERS = 64
"""Arrays of an `.npz` file; ours have 13 at most."""
MAX_DIRECTORY = 64 * KILOBYTE
"""Bytes of an archive's table of contents, which Python reads before anything else."""
MAX_WEIGHTS = 64 * MEGABYTE
"""Bytes of a network's weights; those that come with the library have 1 MB at most."""
MAX_CHECKPOINT = 256 * MEGABYTE
"""Bytes of a training's state: weights, the best ones, and two numbers of Adam for each."""
MAX_TRAJECTORIES = 10_000
"""Of a file. To check one takes 0.1 ms, and a recording of one world has 30."""
MAX_CORNERS = 200_000
"""Of the outlines of a grid's free space, before they are simplified. A floor of 40,000 m² has
20,000; a random grid as large as a picture may be would have a million and keep Python busy for a
minute."""
MAX_SURFACES = 2_000
"""Materials of an imported map, one for each 25 m of outline, and each takes 2 ms to make. A floor
of 40,000 m² has 500."""
MAX_OUTLINE, MAX_BOXES = 1_000, 200
"""Corners of an outline, and boxes of rooms, in HouseExpo's format: a home has some dozens. Whether
sides cross is checked pair by pair, and each box is cut with the whole outline."""
MAX_ROOM_CELLS = 10 * MAX_PIXELS
"""Cells of the boxes around a floor plan's rooms, all together: each is drawn into a grid of its
own to see whether it is closed. Boxes overlap, but not ten times."""
