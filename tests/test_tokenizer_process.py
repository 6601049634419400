"""The process of the tokenizer: it leaks, hangs or dies, and nobody is the wiser."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import pytest

from cgagen.errors import SourceError, ToolchainError
from cgagen.tokenizer import Tokenizer, compile_source
from cgagen.toolchain import TOKENIZER_SHA256, find_node, find_tokenizer
from tests.compile_cases import HEAD, LED, LED_TAIL


@pytest.fixture
def own() -> Iterator[Tokenizer]:
    """A tokenizer of one's own, to be killed."""
    with Tokenizer() as tokenizer:
        yield tokenizer


@pytest.mark.parametrize("end", ["'", "' ", "'\t ", "END\n'", "END\n' ", "' abc"])
def test_a_comment_at_the_very_end_does_not_hang(tokenizer: Tokenizer, end: str) -> None:
    assert tokenizer.compile(LED + end).image.eeprom.endswith(LED_TAIL)


def test_no_source_costs_memory_for_ever(own: Tokenizer) -> None:
    # 400 times 60 kB is more than the whole 16 MB heap of the tokenizer.
    big = LED + ("'" + "x" * 98 + "\n") * 600
    first = own.compile(big).image
    pid = own.pid
    for _ in range(400):
        assert own.compile(big).image == first
    assert own.pid == pid


def test_one_program_leaves_no_trace_in_the_next(own: Tokenizer) -> None:
    before = own.compile(LED)
    for spoil in (HEAD + "DO\n" * 20, HEAD + "#DEFINE a = 1\nfoo", HEAD + "PULSOUT 1,1\n" * 900):
        with pytest.raises(SourceError):
            own.compile(spoil)
        assert own.compile(LED) == before


def test_the_source_map_holds_the_longest_program(tokenizer: Tokenizer) -> None:
    # 7 bits a statement is the least: 16,384 bits, less a header of 14 and the final END.
    rows = tokenizer.compile(HEAD + "STOP\n" * 2337).source_map.statements
    assert [row.bit for row in rows] == list(range(14, 14 + 7 * 2337, 7))
    assert [row.line for row in rows] == list(range(3, 2340))


def test_a_killed_process_is_replaced(own: Tokenizer) -> None:
    first = own.compile(LED)
    pid = own.pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    assert own.compile(LED) == first
    assert own.pid not in (None, pid)


@pytest.mark.parametrize("delay_s", [0.0, 0.001, 0.003, 0.01])
def test_a_kill_in_mid_use_costs_nothing(own: Tokenizer, delay_s: float) -> None:
    expected = own.compile(LED)
    pid = own.pid
    assert pid is not None
    killer = threading.Timer(delay_s, os.kill, (pid, signal.SIGKILL))
    killer.start()
    while own.pid == pid:
        assert own.compile(LED) == expected
    killer.join()
    assert own.compile(LED) == expected
    assert own.pid != pid


def fake(script: str) -> list[str]:
    return [sys.executable, "-u", "-c", script]


def test_a_process_that_does_not_answer_is_stopped() -> None:
    command = fake("import time; print('{\"ready\": 1}'); time.sleep(600)")
    with Tokenizer(0.2, command=command) as tokenizer:
        with pytest.raises(ToolchainError, match=r"slow\.bs2: .* no answer in 0\.2 s"):
            tokenizer.compile(LED, "slow.bs2")
        assert tokenizer.pid is None


def test_a_process_that_does_not_read_is_stopped() -> None:
    command = fake("import time; print('{\"ready\": 1}'); time.sleep(600)")
    big = LED + "'" * 65_000 + "\n"
    with Tokenizer(0.2, command=command) as tokenizer:
        for _ in range(2):  # 65 kB is more than a pipe holds
            with pytest.raises(ToolchainError, match="no answer"):
                tokenizer.compile(big)


@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("print('{\"ready\": 1}'); input()", "died twice"),
        ("print('{\"ready\": 1}'); input(); print('no JSON'); input()", "died twice .*JSON"),
        ("print('{\"ready\": 1}'); input(); print('{\"id\": 99}'); input()", "out of turn"),
        ('print(\'{"ready": 1}\'); input(); print(\'{"id": 1, "fatal": "abort"}\')', "abort"),
        ("raise SystemExit(1)", "did not start"),
        ('print(\'{"fatal": "hash 00"}\')', "hash 00"),
        ("print('[]')", "did not start"),
        ("raise ValueError('odd machine')", "ValueError: odd machine"),
    ],
)
def test_a_sick_process_is_one_sentence(script: str, words: str) -> None:
    with Tokenizer(60, command=fake(script)) as tokenizer:
        with pytest.raises(ToolchainError, match=words) as caught:
            tokenizer.compile(LED)
        assert "\n" not in str(caught.value)


def test_a_program_that_is_not_there_is_one_sentence() -> None:
    with (
        Tokenizer(command=["/nonexistent/node"]) as tokenizer,
        pytest.raises(ToolchainError, match="does not start"),
    ):
        tokenizer.compile(LED)


def test_a_fork_gets_its_own_process(own: Tokenizer) -> None:
    expected = own.compile(LED)
    mine = own.pid
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12: fork beside threads
        child = os.fork()
    if child == 0:  # pragma: no cover - another process
        verdict = b"bad"
        try:
            good = own.compile(LED) == expected and own.pid not in (None, mine)
            own.close()
            verdict = b"good" if good else b"same"
        finally:
            os.write(writing, verdict)
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        assert pipe.read() == b"good"
    os.waitpid(child, 0)
    assert own.compile(LED) == expected
    assert own.pid == mine


def test_threads_take_turns(own: Tokenizer) -> None:
    sources = [f"' {{$STAMP BS2}}\nHIGH {pin}\n" for pin in range(8)]
    expected = [own.compile(source).image for source in sources]
    seen: dict[int, list[bool]] = {}

    def work(index: int) -> None:
        seen[index] = [own.compile(sources[index]).image == expected[index] for _ in range(20)]

    threads = [threading.Thread(target=work, args=(index,)) for index in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(all(seen[index]) and len(seen[index]) == 20 for index in range(8))


def test_the_process_ends_with_its_owner() -> None:
    script = (
        "from cgagen.tokenizer import Tokenizer\n"
        't = Tokenizer(); t.compile("\' {$STAMP BS2}\\nHIGH 3\\n"); print(t.pid, flush=True)\n'
        "import time; time.sleep(600)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL
    ) as owner:
        assert owner.stdout is not None
        worker = int(owner.stdout.readline())
        group = os.getpgid(worker)
        owner.kill()
        owner.wait()
    assert group == worker  # so Ctrl-C on a terminal does not reach it
    for _ in range(500):
        if not _alive(worker):
            break
        time.sleep(0.02)
    assert not _alive(worker)


def _alive(pid: int) -> bool:
    row = _stat(Path(f"/proc/{pid}/stat"))
    return bool(row) and row[0] != "Z"


def _stat(path: Path) -> list[str]:
    """State, parent and more of a process; nothing where it is gone."""
    try:
        return path.read_text().rpartition(")")[2].split()
    except OSError:
        return []


def test_a_closed_tokenizer_says_so(own: Tokenizer) -> None:
    own.compile(LED)
    own.close()
    own.close()
    with pytest.raises(ValueError, match="closed"):
        own.compile(LED)


def test_the_worker_warns_of_nothing_and_keeps_no_handler(tmp_path: Path) -> None:
    hook = tmp_path / "hook.cjs"
    hook.write_text(
        "process.on('exit', () => console.error(process.listenerCount('uncaughtException')))"
    )
    worker = str(resources.files("cgagen.tokenizer") / "worker.cjs")
    done = subprocess.run(
        [find_node().path, "-r", hook, worker, find_tokenizer(), TOKENIZER_SHA256],
        input=json.dumps({"id": 1, "source": LED}) + "\n",
        capture_output=True,
        text=True,
        check=True,
        env={key: value for key, value in os.environ.items() if not key.startswith("NODE_")},
    )
    assert [json.loads(line).get("ok") for line in done.stdout.splitlines()] == [None, True]
    assert done.stderr.split() == ["0"]


def test_one_tokenizer_is_shared() -> None:
    first, before = compile_source(LED), _children()
    assert compile_source(LED) == first
    assert _children() == before


def _children() -> set[int]:
    stats = {path: _stat(path) for path in Path("/proc").glob("[0-9]*/stat")}
    return {int(p.parent.name) for p, row in stats.items() if row and int(row[1]) == os.getpid()}
