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


@pytest.fixture
def short_hello(monkeypatch: pytest.MonkeyPatch) -> None:
    """For greetings on a bus that shall fail."""
    monkeypatch.setattr("hil.can_session.HELLO_S", 0.5)
    monkeypatch.setattr("hil.can_session.TRY_S", 0.1)


@pytest.fixture
def short_take(monkeypatch: pytest.MonkeyPatch) -> None:
    """For questions on a bus that shall not be taken."""
    monkeypatch.setattr("hil.can_session.TAKE_S", 0.3)


@pytest.fixture
def short_life(monkeypatch: pytest.MonkeyPatch) -> None:
    """For rigs on a bus that shall die."""
    monkeypatch.setattr("hil.can_session.TAKE_S", 0.3)
    monkeypatch.setattr("hil.can_session.LIFE_S", 0.5)
