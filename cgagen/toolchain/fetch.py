"""Set-up: the tokenizer comes from npm, or from a file where there is no network."""

import contextlib
import os
import re
import subprocess
import tarfile
from importlib import resources
from io import BytesIO
from pathlib import Path

from cgagen.errors import NetworkError, StorageError, ToolchainError
from cgagen.files import digest, make_folder, write_bytes
from cgagen.inputs import gunzipped, read_bytes
from cgagen.temporaries import temporary_folder
from cgagen.toolchain.cache import (
    PACKAGE,
    TOKENIZER,
    TOKENIZER_SHA256,
    VERSION,
    find_tokenizer,
    tokenizer_path,
)
from cgagen.toolchain.node import clean_environment, find_node

FETCH_LIMIT_S = 180
"""How long npm may take before it is stopped. Ref: choice; it takes 1 s on a good line."""

_NPM_WORDS = (
    "ci",
    "--ignore-scripts",
    "--no-audit",
    "--no-fund",
    "--no-update-notifier",
    "--fetch-retries=1",
    "--fetch-retry-mintimeout=1000",
    "--fetch-retry-maxtimeout=2000",
    "--fetch-timeout=60000",
)
_NETWORK_CODES = re.compile(
    r"\b(E(?:NOTFOUND|CONN\w+|TIMEDOUT|SOCKETTIMEDOUT|AI_AGAIN|NETUNREACH|HOSTUNREACH|PIPE"
    r"|[45]\d\d|NEEDAUTH|NOTCACHED)|ERR_SOCKET_TIMEOUT|\w*CERT\w*|ERR_SSL\w*|ERR_TLS\w*)\b"
)
_SPOILED_CODES = ("EINTEGRITY", "TAR_BAD_ARCHIVE", "Z_DATA_ERROR", "Z_BUF_ERROR")
_LARGEST = 8 << 20
"""Bytes of the largest file that is read from a tarball; the tokenizer has 1 MB."""


def setup(offline: Path | None = None, force: bool = False) -> tuple[Path, bool]:
    """Put the tokenizer into the user's cache, unless the right one is there already.

    Args:
        offline: a tarball made by `npm pack pbasic-tokenizer@0.3.0`, or its index.js.
        force: fetch it again, whatever is there.

    Returns:
        The tokenizer's file, and whether it was put there by this call.

    Raises:
        NetworkError: it could not be fetched.
        ToolchainError: no Node or npm, or what came has the wrong hash.
        StorageError: the cache cannot be written.
    """
    if offline is None and not force:
        try:
            return find_tokenizer(), False
        except ToolchainError:
            if os.environ.get("CGAGEN_TOKENIZER"):
                raise
    files = _from_npm() if offline is None else _from_file(offline)
    found = digest(files["index.js"])
    if found != TOKENIZER_SHA256:
        raise ToolchainError(
            f"{offline or 'what npm delivered'} is not the tokenizer of {PACKAGE} {VERSION} (its "
            f"hash is {found[:12]}, not {TOKENIZER_SHA256[:12]}) and was not kept; "
            f"give the file of `npm pack {PACKAGE}@{VERSION}`"
        )
    target = tokenizer_path()
    make_folder(target.parent)
    with contextlib.suppress(OSError):  # of another user; then it is refused when it is looked for
        target.parent.chmod(0o700)
    for name in sorted(files):
        write_bytes(target.with_name(name), files[name])
        target.with_name(name).chmod(0o644)  # an older one's may have been wider
    return target, True


def _from_npm() -> dict[str, bytes]:
    npm = find_node().npm()
    root = tokenizer_path().parent.parent
    make_folder(root)
    try:
        with temporary_folder(root) as work:
            return _installed(npm, work)
    except OSError as error:
        raise StorageError(
            f"{root}: cannot be written ({error.strerror}); free some space or set XDG_CACHE_HOME"
        ) from error


def _installed(npm: list[str], work: Path) -> dict[str, bytes]:
    """Return the files that npm puts into a folder."""
    for name in ("package.json", "package-lock.json"):
        write_bytes(work / name, (resources.files("cgagen") / "npm" / name).read_bytes())
    _run_npm(npm, work)
    folder = work / "node_modules" / PACKAGE
    try:
        return {name: (folder / name).read_bytes() for name in ("index.js", "LICENSE")}
    except OSError as error:
        raise ToolchainError(f"npm left no {PACKAGE} behind; run `cgagen setup` again") from error


def _run_npm(npm: list[str], work: Path) -> None:
    environment = clean_environment()
    # npm's own programs ask PATH for `node`; the one that we found may not be on it.
    folder = str(Path(npm[0]).parent)
    environment["PATH"] = os.pathsep.join([folder, environment.get("PATH", "")])
    try:
        done = subprocess.run(
            [*npm, *_NPM_WORDS],
            cwd=work,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=FETCH_LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise NetworkError(
            f"npm did not fetch the tokenizer in {FETCH_LIMIT_S} s; try again, or use "
            "`cgagen setup --offline FILE`"
        ) from error
    except OSError as error:
        raise ToolchainError(
            f"{npm[0]}: cannot be run ({error.strerror}); mend the installation of Node"
        ) from error
    if done.returncode != 0:
        raise _npm_error(done.stdout.decode("utf-8", "replace"))


def _npm_error(output: str) -> NetworkError | ToolchainError:
    if any(code in output for code in _SPOILED_CODES):
        return ToolchainError(
            f"the registry delivered a {PACKAGE} {VERSION} with a wrong hash, which was not kept; "
            f"give the right one with `cgagen setup --offline FILE`"
        )
    code = _NETWORK_CODES.search(output)
    if code is not None:
        return NetworkError(
            f"the tokenizer could not be fetched by npm ({code[0]}); check the network, or give "
            f"the file of `npm pack {PACKAGE}@{VERSION}` with `cgagen setup --offline FILE`"
        )
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    lines = [line for line in lines if not line.startswith("npm warn")]
    words = lines[0] if lines else "it said nothing"
    return ToolchainError(
        f"npm did not install the tokenizer ({words}); mend that, or use "
        "`cgagen setup --offline FILE`"
    )


def _from_file(path: Path) -> dict[str, bytes]:
    content = read_bytes(path, TOKENIZER)
    if not content.startswith(b"\x1f\x8b"):
        return {"index.js": content}
    files: dict[str, bytes] = {}
    try:
        # Members are read into memory by name; nothing is ever unpacked to where it says.
        whole = gunzipped(content, path, TOKENIZER)
        with tarfile.open(fileobj=BytesIO(whole), mode="r:") as archive:
            for member in archive:
                name = member.name.removeprefix("package/")
                wanted = member.name == f"package/{name}" and name in ("index.js", "LICENSE")
                if wanted and member.isfile() and member.size <= _LARGEST:
                    file = archive.extractfile(member)
                    files[name] = file.read() if file is not None else b""
    except (tarfile.TarError, EOFError, OSError, ValueError, OverflowError) as error:
        raise ToolchainError(
            f"{path}: is not a whole tarball ({error}); make it again with "
            f"`npm pack {PACKAGE}@{VERSION}`"
        ) from error
    if "index.js" not in files:
        raise ToolchainError(
            f"{path}: holds no package/index.js; give the file of `npm pack {PACKAGE}@{VERSION}`"
        )
    return files
