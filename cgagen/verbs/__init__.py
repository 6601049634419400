"""The verbs of the command line, one small file each; `cgagen.cli` is their table."""
