"""Robot and genome -> the PBASIC of both Stamps.

`generate` is the way in. The words that the templates may use are made by `main_words` and
`locomotion_words`; `gait_tables` and `timing` know what the servos need, `pins` what hangs on
which pin, `render` everything about Jinja. Nothing here writes a file or runs a tool.
"""

from cgagen.firmware.generate import (
    LOCOMOTION_FILE,
    MAIN_FILE,
    Firmware,
    Program,
    generate,
    source_digest,
)

__all__ = ["LOCOMOTION_FILE", "MAIN_FILE", "Firmware", "Program", "generate", "source_digest"]
