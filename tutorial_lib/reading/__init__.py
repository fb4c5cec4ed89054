"""One hardened way to read each kind of file: every fault is named, and no file can hurt.

A reader takes a path and what to do about a file that cannot be read. It raises `InputError`, one
line that begins with the path and ends with that advice, for whatever is wrong. It opens only
regular files, and looks at the sizes that a file declares before it reserves memory for them; see
`limits`. Nothing is ever unpickled, and no code runs.
"""
