"""The error that a person is meant to read."""


class InputError(ValueError):
    """Something given from outside is wrong: one line that says what, where, and what to do.

    The command line prints it without a traceback.
    """
