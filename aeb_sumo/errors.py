"""What a user can get wrong."""

__all__ = ["InputError"]


class InputError(ValueError):
    """Bad input; the message is one line that names the thing and what is allowed."""
