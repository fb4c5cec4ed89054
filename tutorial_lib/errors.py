"""The error whose message is meant for users."""


class InputError(ValueError):
    """Invalid input: one line that says what is wrong, where, and what to do.

    The command line prints it without a traceback.
    """
