"""Tables in Markdown, taken apart."""


def cells(text):
    """The cells of each line, head first; what rules the head off is left out."""
    head, rule, *lines = [line.strip("|").split("|") for line in text.splitlines()]
    assert rule == ["---"] * len(head)
    assert all(len(line) == len(head) for line in lines)
    return [[cell.strip() for cell in line] for line in (head, *lines)]
