"""Files as people save them: in other encodings, with other decimal signs, broken off, too large."""

import codecs

import pytest

from railvib.errors import InputError
from sweep.study.files import LARGEST_FILE, read_toml

TEXT = '[study]\nname = "Gröna"\n'


def refusal(path):
    with pytest.raises(InputError) as caught:
        read_toml(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert message.isprintable()
    assert len(message) < 500
    return message.removeprefix(f"{path}: ")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_utf_8_with_or_without_a_mark(tmp_path, encoding, end):
    path = tmp_path / "study.toml"
    path.write_bytes(TEXT.replace("\n", end).encode(encoding))
    assert read_toml(path) == {"study": {"name": "Gröna"}}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (TEXT.encode("utf-16"), "is in UTF-16, must be in UTF-8: save the file as UTF-8"),
        (codecs.BOM_UTF16_BE + TEXT.encode("utf-16-be"), "is in UTF-16, must be in UTF-8"),
        (TEXT.encode("utf-32"), "is in UTF-32, must be in UTF-8"),
        (TEXT.encode("utf-16-le"), "holds zero bytes, as text in UTF-16 does"),
        (TEXT.encode("latin-1"), "line 2 holds the byte 0xf6, which is no UTF-8; in Latin-1 it is 'ö': save"),
        (b"tolerance = 0,001\n", "at line 1, column 14); the decimal sign is a point: write 0.001"),
        (b"[a]\nlayers = [{ thickness_m = 1,5, loss_factor = 1 }]\n", "a point: write 1.5"),
        (b'[study]\nname = "half\n', "is not valid TOML: Illegal character '\\n' (at line 2, column 13)"),
        (b"\x00", "holds zero bytes"),
        (b"a = " + b"[" * 100_000, "its lists or tables are nested too deeply"),
        (b"a = " + b"{a = " * 100_000, "its lists or tables are nested too deeply"),
        (b"a = " + b"1" * 5_000, "is not valid TOML"),
        (b"a = 2000-02-31", "is not valid TOML"),
        (b"a = 1\n" * 2, "is not valid TOML: Cannot overwrite a value"),
        (b"#" * (LARGEST_FILE + 1), f"has more than {LARGEST_FILE} bytes"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_what_cannot_be_read_is_refused_with_a_remedy(tmp_path, content, message):
    path = tmp_path / "study.toml"
    path.write_bytes(content)
    assert message in refusal(path)


def test_what_is_no_file_is_refused(tmp_path):
    assert refusal(tmp_path) == "cannot be read: Is a directory"
    assert refusal(tmp_path / "none.toml") == "cannot be read: No such file or directory"
