"""What several test files share. `make setup` has put the tokenizer into the cache."""

from collections.abc import Iterator

import pytest
from hypothesis import settings

from cgagen.tokenizer import Tokenizer

# How long an example takes says something of the machine's load and nothing of the code.
settings.register_profile("steady", deadline=None)
settings.load_profile("steady")


@pytest.fixture(scope="session")
def tokenizer() -> Iterator[Tokenizer]:
    """One worker for the whole session; tests that kill workers make their own."""
    with Tokenizer() as shared:
        yield shared
