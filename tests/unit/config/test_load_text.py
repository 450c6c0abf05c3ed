"""Reading documents: what is refused, and how the complaint reads."""

import pytest

from mamo_core.config import Located, load_file, load_text
from mamo_core.errors import InputError


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("a: 1\nb: [1.5, -2e-3, .5]\n", {"a": 1, "b": [1.5, -0.002, 0.5]}),
        ('{"a": [true, null, "x"]}', {"a": [True, None, "x"]}),
        (
            "a: yes\nb: 2024-01-01\nc: 012\nd: 0x1f",
            {"a": "yes", "b": "2024-01-01", "c": 12, "d": 31},
        ),
        ("a: '1'\nb: \"true\"\nc: ~\nd:", {"a": "1", "b": "true", "c": None, "d": None}),
        ("1: one\n<<: x\n", {"1": "one", "<<": "x"}),
        ("- .inf\n- -.inf\n", [float("inf"), -float("inf")]),
    ],
)
def test_data(text, data):
    assert load_text(text, "f").data == data


def test_places_are_the_same_for_json_and_yaml():
    for text in ('{"a":\n  {"b": 3}}', "a:\n  b:  3"):
        located = load_text(text, "f.yaml")
        assert located.places.values[("a", "b")] == (2, 9 if text[0] == "{" else 7)
        assert located.where(("a", "b"), key=True) == f"f.yaml:2:{4 if text[0] == '{' else 3}"


def test_places_count_from_the_first_line():
    assert load_text('{"a": 1}', "f.jsonl", first_line=7).where(("a",)) == "f.jsonl:7:7"


def test_a_missing_path_stands_where_its_parent_stands():
    located = load_text("a:\n  b: 1\n", "f").at("a")
    assert located.where(("c", "d")) == "f:2:3"
    assert located.dotted(("c",)) == "a.c"
    assert str(located.error("is wrong", ("b",))) == "f:2:6: is wrong"


def test_data_without_text_names_its_source_alone():
    assert Located({"a": 1}, "plan.json: recipe").at("a").where() == "plan.json: recipe"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "f:1:1: the document is empty"),
        ("# nothing\n", "f:1:1: the document is empty"),
        ("a: 1\na: 2\n", "f:2:1: duplicate key 'a', first on line 1"),
        ('{"a": 1,\n "a": 2}', "f:2:2: duplicate key 'a', first on line 1"),
        ("a: &x 1\n", "f:1:4: anchor '&x': anchors are not allowed"),
        ("a: *x\n", "f:1:4: alias '*x': aliases are not allowed"),
        ("a: !!int '1'\n", "f:1:4: tag '!!int': tags are not allowed"),
        ("a: !shell rm\n", "f:1:4: tag '!shell': tags are not allowed"),
        ("a: 1\n---\nb: 2\n", "f:3:1: a second document, expected only one"),
        ("%YAML 1.1\n---\na: 1\n", "f:2:1: directives are not allowed"),
        ("? [a]\n: 1\n", "f:1:3: a key that is a list or mapping, expected text"),
        ("a: \x01", "f:1:4: character 1 is not allowed"),
        ("a: " + "9" * 5000, "f:1:4: a number with too many digits"),
        (
            '{"a": 1,\n "b": [1, 2',
            "f:2:12: not valid YAML or JSON: while parsing a flow sequence: "
            "expected ',' or ']', but got the end of the file",
        ),
        ("a: b: c", "f:1:5: not valid YAML or JSON: mapping values are not allowed here"),
    ],
)
def test_refused(text, complaint):
    with pytest.raises(InputError) as caught:
        load_text(text, "f")
    assert str(caught.value) == complaint


@pytest.mark.parametrize("text", ["[" * 41 + "]" * 41, "[" * 9000, '{"a":' * 41 + "1" + "}" * 41])
def test_too_deep(text):
    with pytest.raises(InputError, match=r"^f:1:\d+: nested deeper than 40 levels$"):
        load_text(text, "f")


def test_forty_levels_are_fine():
    assert load_text("[" * 40 + "]" * 40, "f").data


def test_too_large():
    with pytest.raises(InputError, match=r"^f: 300000 bytes, expected at most 262144$"):
        load_text("a" * 300000, "f")


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match=r"none.yaml: no such file$"):
        load_file(tmp_path / "none.yaml")
    with pytest.raises(InputError, match=r": cannot be read: Is a directory$"):
        load_file(tmp_path)
    latin = tmp_path / "latin.yaml"
    latin.write_bytes("a: 1\nb: \xe4".encode("latin-1"))
    with pytest.raises(InputError, match=r"latin.yaml:2:4: not UTF-8 text$"):
        load_file(latin)
    large = tmp_path / "large.yaml"
    large.write_text("a" * 300000)
    with pytest.raises(InputError, match=r"large.yaml: larger than 262144 bytes$"):
        load_file(large)
