"""Genome and robot -> a folder with the programs, images and papers of both Stamps.

`make_build` composes it as a value; `write_build` puts it on the disk, whole or not at all;
`read_image` takes an image out of it again, with everything that is known of its bytes.
"""

from cgagen.build.folder import check_build_folder, write_build
from cgagen.build.make import Build, BuiltProgram, make_build
from cgagen.build.record import FILES, FORMAT, read_image, read_record

__all__ = [
    "FILES",
    "FORMAT",
    "Build",
    "BuiltProgram",
    "check_build_folder",
    "make_build",
    "read_image",
    "read_record",
    "write_build",
]
