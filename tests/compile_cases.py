"""Small programs for the tests of the tokenizer."""

HEAD = "' {$STAMP BS2}\n' {$PBASIC 2.5}\n"
LED = "' {$STAMP BS2}\nHIGH 3\n"
LED_TAIL = bytes.fromhex("140e07c0")
