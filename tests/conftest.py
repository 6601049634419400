"""What several test files share. `make setup` has put the tokenizer into the cache."""

from collections.abc import Iterator

import pytest

from cgagen.tokenizer import Tokenizer


@pytest.fixture(scope="session")
def tokenizer() -> Iterator[Tokenizer]:
    """One worker for the whole session; tests that kill workers make their own."""
    with Tokenizer() as shared:
        yield shared
