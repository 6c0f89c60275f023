"""Calls that are refused with a sentence."""

import pytest

from ancfsparse.errors import InputError


def assert_refused(words, call, *arguments, error=InputError, **options):
    """Assert that a call with these arguments is refused with these words, and return the error."""
    with pytest.raises(error, match=words) as caught:
        call(*arguments, **options)
    return caught.value
