"""Words for messages."""

__all__ = ["a_kind_of"]


def a_kind_of(something: object) -> str:
    """Return the name of the type of an object after its article.

    Examples
    --------
    >>> a_kind_of(3), a_kind_of("word")
    ('an int', 'a str')
    """
    name = type(something).__name__
    return f"{'an' if name[0] in 'AEIOaeio' else 'a'} {name}"
