"""What several test files share. `make setup` has put the tokenizer into the cache."""

import signal
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path

import pytest
from hypothesis import settings

from cgagen.cli import main
from cgagen.tokenizer import Tokenizer
from tests.emulate_cases import Emulate, Program

# How long an example takes says something of the machine's load and nothing of the code.
settings.register_profile("steady", deadline=None)
settings.load_profile("steady")

# A shell's background job ignores Ctrl-C, and so would the programs that tests interrupt.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def tokenizer() -> Iterator[Tokenizer]:
    """One worker for the whole session; tests that kill workers make their own."""
    with Tokenizer() as shared:
        yield shared


@pytest.fixture
def short_hello(monkeypatch: pytest.MonkeyPatch) -> None:
    """For greetings on a bus that shall fail."""
    monkeypatch.setattr("hil.can_session.HELLO_S", 1.0)
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


@pytest.fixture(scope="session", autouse=True)
def own_state(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Traces of bugs that tests provoke are none of the user's."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture
def emulate(
    capfdbinary: pytest.CaptureFixture[bytes],
    tokenizer: Tokenizer,
    monkeypatch: pytest.MonkeyPatch,
) -> Emulate:
    """Call `cgagen emulate`; stdout is bytes as latin-1, so that CR stays CR.

    All calls share one tokenizer, because starting one takes most of a call's time.
    """

    def shared(warn: Callable[[str], None]) -> nullcontext[Tokenizer]:
        monkeypatch.setattr(tokenizer, "_warn", warn)
        return nullcontext(tokenizer)

    monkeypatch.setattr("cgagen.verbs.emulate_bench.Tokenizer", shared)

    def call(*words: object) -> tuple[int, str, str]:
        code = main(["emulate", *map(str, words)])
        out, err = capfdbinary.readouterr()
        return code, out.decode("latin-1"), err.decode()

    return call


@pytest.fixture
def program(tmp_path: Path) -> Program:
    """Write a source."""

    def write(text: str, name: str = "it.bs2") -> Path:
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the tokenizer would be on a machine on which nothing was set up yet."""
    for name in ("CGAGEN_NODE", "CGAGEN_TOKENIZER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("npm_config_cache", str(tmp_path / "npm-cache"))
    for name in ("npm_config_noproxy", "NO_PROXY", "no_proxy"):
        monkeypatch.setenv(name, "127.0.0.1")
    return tmp_path / "cache"
