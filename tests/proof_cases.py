"""What is to be proven of both robots, and their programs with changes."""

from dataclasses import replace
from functools import cache

from cgagen.stamp.image import Image
from cgagen.tokenizer import Tokenizer
from hil.equivalence import Verdict
from hil.proof import Question
from hil.subject import Subject
from tests.subjects import subject

PASS, FAIL, UNPROVEN = Verdict.PASS, Verdict.FAIL, Verdict.UNPROVEN


@cache
def questions() -> dict[str, Question]:
    return {role: Question(subject(role)) for role in ("predator", "prey")}


def with_source(subject: Subject, tokenizer: Tokenizer, *changes: tuple[str, str]) -> Subject:
    """A subject whose main source was changed and compiled."""
    source = subject.sources["main"]
    for old, new in changes:
        assert old in source, old
        source = source.replace(old, new)
    return with_image(subject, tokenizer.compile(source, "main.bsp").image)


def with_image(subject: Subject, image: Image) -> Subject:
    return replace(subject, images={**subject.images, "main": image})
