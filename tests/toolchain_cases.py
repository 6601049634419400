"""The Node and the tokenizer of this machine, and programs that are none."""

from pathlib import Path

from cgagen.toolchain import find_node, find_tokenizer

LED = "' {$STAMP BS2}\nHIGH 3\n"
REAL_NODE = find_node().path
REAL_TOKENIZER = find_tokenizer()


def executable(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)
    return path
