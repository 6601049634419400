"""Genomes as text and as values, and texts that are no genome."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cgagen import files, genome
from cgagen.errors import GenomeError
from cgagen.genome import Genome, Origin

BITS = "".join(f"{n % 8:03b}" for n in range(64))
INTERFACE = "sonar front, sonar right, antenna left, light left; 8 x 8 situations; Table I"

texts = st.text(st.characters(exclude_categories=["Cs"]), min_size=1).filter(str.strip)
origins = st.builds(
    Origin,
    seed=st.none() | st.integers(0, 2**63 - 1),
    trial=st.none() | st.integers(1, 99),
    generation=st.none() | st.integers(1, 10**6),
    fitness=st.none() | st.floats(allow_nan=False, allow_infinity=False),
    robot_digest=st.none() | st.text(st.characters(exclude_categories=["Cs"])),
    versions=st.dictionaries(texts, texts).map(lambda d: tuple(sorted(d.items()))),
)
genomes = st.builds(
    Genome,
    bits=st.text("01", min_size=192, max_size=192),
    robot=texts,
    interface=st.none() | texts,
    origin=origins,
)


@given(genomes)
def test_text_and_back(one):
    assert genome.parse(genome.to_text(one), "x") == one


@given(st.lists(st.integers(0, 7), min_size=64, max_size=64))
def test_commands_array_and_back(commands):
    one = genome.from_commands(commands)
    assert one.commands() == tuple(commands)
    assert genome.from_array(one.array()).bits == one.bits
    assert one.array().dtype == "uint8"
    assert one.array().tolist() == [int(bit) for bit in one.bits]


def test_file_and_back(tmp_path):
    one = Genome(BITS, "servobot-predator", INTERFACE, Origin(seed=7, trial=2, fitness=651.25))
    path = tmp_path / "best.genome"
    files.write_text(path, genome.to_text(one))
    assert genome.load(path) == one


def test_the_text_is_a_table_for_people():
    text = genome.to_text(Genome(BITS, interface=INTERFACE))
    lines = text.splitlines()
    first = lines.index('bits = """') + 1
    assert lines[first] == "000 001 010 011 100 101 110 111"
    row = next(line for line in lines if line.startswith("# near_right "))
    assert row.split()[2:4] == ["FORWARD", "BACKWARD"]
    assert max(map(len, lines)) < 140


def test_gene_zero_comes_first_and_its_high_bit_first():
    assert Genome("100" + "0" * 189).commands() == (4,) + (0,) * 63  # Ref: S1 figure 5


def test_bare_characters_are_the_papers_robot():
    one = genome.parse(" ".join(BITS) + "\r\n", "fig5.txt")
    assert (one.bits, one.robot, one.interface) == (BITS, "servobot-predator", None)
    note = genome.check_interface(one, "mine", INTERFACE)
    assert note is not None
    assert "mine" in note


def test_digest_is_of_the_bits_alone():
    assert Genome(BITS).digest == files.digest(BITS)
    assert Genome(BITS, "a", "b", Origin(seed=1)).digest == files.digest(BITS)


TOML = genome.to_text(Genome(BITS, "r", INTERFACE, Origin(seed=1, fitness=2.5)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BITS[:-1], ["191 bits", "192"]),
        (BITS + "0", ["193 bits"]),
        ("", ["0 bits"]),
        (BITS[:16] + "2" + BITS[17:], ["'2'", "character 17", "gene 5", "near_front", "bit 2"]),
        (BITS + "x", ["'x'", "character 193"]),
        ("hello world", ["'h'"]),
        (TOML.replace("cgagen-genome-1", "cgagen-genome-9"), ["cgagen-genome-9", "-genome-1"]),
        (TOML.replace('robot = "r"', 'robto = "r"'), ["robto", "allowed", "robot"]),
        (TOML.replace('robot = "r"\n', ""), ["robot is missing"]),
        (TOML.replace('robot = "r"', 'robot = ""'), ["robot is ''"]),
        (TOML.replace('robot = "r"', "robot = 3"), ["robot is 3"]),
        (TOML.replace("000 001 010", "000 021 010", 1), ["bits: has '2'", "character 5"]),
        (TOML.replace("000 001 010", "000 01 010", 1), ["bits: has 191 bits"]),
        (TOML.replace("seed = 1", "seed = -1"), ["[origin] seed", "-1"]),
        (TOML.replace("seed = 1", "seed = true"), ["[origin] seed"]),
        (TOML.replace("seed = 1", "sede = 1"), ["[origin] the key sede"]),
        (TOML.replace("fitness = 2.5", "fitness = nan"), ["fitness is nan"]),
        (TOML.replace("fitness = 2.5", "versions = 2"), ["versions"]),
        (TOML.replace("seed = 1", "seed = = 1"), ["is not TOML", "line"]),
        (TOML.split("[origin]")[0] + "\n", None),
        (TOML.replace("\nbits", "\norigin = 3\nbits").split("[origin]")[0], ["origin is 3"]),
    ],
)
def test_refusals_are_one_sentence_with_the_file(text, words):
    if words is None:
        assert genome.parse(text, "x").origin == Origin()
        return
    with pytest.raises(GenomeError) as caught:
        genome.parse(text, "some/best.genome")
    sentence = str(caught.value)
    assert sentence.startswith("some/best.genome: ")
    assert "\n" not in sentence
    for word in words:
        assert word in sentence


def test_files_that_are_no_genome(tmp_path):
    (tmp_path / "binary").write_bytes(b"0101\xff0101")
    (tmp_path / "large").write_bytes(b"0" * 70_000)
    for name, word in [
        ("binary", "byte 4"),
        ("large", "70,000"),
        (".", "is a folder"),
        ("none", "No such"),
    ]:
        with pytest.raises(GenomeError, match=word):
            genome.load(tmp_path / name)
    (tmp_path / "mark").write_bytes(b"\xef\xbb\xbf" + BITS.encode())
    assert genome.load(tmp_path / "mark").bits == BITS


@pytest.mark.parametrize("bits", [BITS[:-1], BITS[:-1] + "2", ""])
def test_a_wrong_argument_is_a_value_error(bits):
    with pytest.raises(ValueError, match="a genome has"):
        Genome(bits)


def test_wrong_commands_are_value_errors():
    for commands in ([0] * 63, [8] + [0] * 63, [-1] + [0] * 63):
        with pytest.raises(ValueError, match="64 commands"):
            genome.from_commands(commands)
    with pytest.raises(ValueError, match="shape"):
        genome.from_array(Genome(BITS).array()[:-1])


def test_another_interface_is_refused_and_named():
    one = Genome(BITS, "servobot-predator", "sonar 0, sonar 30, light 25; Table I")
    with pytest.raises(GenomeError) as caught:
        genome.check_interface(one, "mine", "sonar 0, sonar 45, light 25; Table I")
    for word in ("'sonar 30'", "'sonar 45'", "servobot-predator", "mine"):
        assert word in str(caught.value)
    with pytest.raises(GenomeError, match="'Table I' where mine has nothing"):
        genome.check_interface(one, "mine", "sonar 0, sonar 30, light 25")


def test_what_a_genome_does_not_depend_on_is_a_note():
    one = Genome(BITS, "servobot-predator", INTERFACE, Origin(robot_digest="aa"))
    assert genome.check_interface(one, "servobot-predator", INTERFACE) is None
    assert genome.check_interface(one, "servobot-predator", INTERFACE, "aa") is None
    changed = genome.check_interface(one, "servobot-predator", INTERFACE, "bb")
    assert changed is not None
    assert "changed" in changed
    renamed = genome.check_interface(one, "mine", INTERFACE, "bb")
    assert renamed is not None
    assert "mine" in renamed
