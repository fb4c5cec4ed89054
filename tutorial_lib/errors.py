"""The error whose message is meant for users, and the warning."""

MAX_MESSAGE = 1_000
"""Characters of a message, at most: it quotes what is wrong, which may be a megabyte."""

MAX_QUOTE = 300
"""Characters of an error of somebody else's code, within a message."""


class InputError(ValueError):
    """Invalid input: one line that says what is wrong, where, and what to do.

    The command line prints it without a traceback. Line ends, control characters and halves of
    characters in what the message quotes are replaced, and a long message is cut in its middle.
    """

    def __init__(self, message: object) -> None:
        super().__init__(one_line(str(message)))


class Notice(UserWarning):
    """What was done about input that is not quite in order; the command line prints it as a line.

    To be given to `warnings.warn`.
    """

    def __init__(self, message: object) -> None:
        super().__init__(one_line(str(message)))


def one_line(text: str, most: int = MAX_MESSAGE) -> str:
    """Text on one line that any terminal can print, at most so many characters.

    >>> one_line("two" + chr(10) + "lines"), one_line("a long message; what to do", 18)
    ('two lines', 'a long … at to do')
    """
    if len(text) > 4 * most:  # before anything is done to each character
        text = text[: 2 * most] + text[-2 * most :]
    text = "".join(c if c.isprintable() else " " if c.isspace() else "\ufffd" for c in text)
    text = " ".join(text.split())
    half = most // 2
    short = f"{text[: half - 2].rstrip()} … {text[1 - half :].lstrip()}"
    return text if len(text) <= most else short


def words_of(error: BaseException, most: int = MAX_QUOTE) -> str:
    """An error of somebody else's code in one line; also one whose message cannot be had."""
    try:
        message = str(error)
    except BaseException as another:
        if isinstance(another, KeyboardInterrupt):
            raise
        message = f"no message, since its __str__ raised {type(another).__name__}"
    return one_line(f"{type(error).__name__}: {message}", most)
