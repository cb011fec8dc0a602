"""Text of a file that a person has written: UTF-8, with or without a byte order mark."""

from pathlib import Path

UTF_16 = (b"\xff\xfe", b"\xfe\xff")


def read_text(path: Path, wanted: str, failure: type[ValueError]) -> str:
    """The file's text without a byte order mark. wanted: what to give in its place, for the messages

    raises: `failure` where the file is missing, a folder, not to be read, or no text in UTF-8: with the line
    """
    try:
        content = path.read_bytes() if not path.is_dir() else None
    except FileNotFoundError:
        raise failure(f"{path}: no such file; give {wanted}") from None
    except OSError as error:
        raise failure(f"{path}: cannot be read: {error.strerror}; give {wanted}") from None
    if content is None:
        raise failure(f"{path}: cannot be read: it is a folder; give {wanted}")
    if content.startswith(UTF_16):
        raise failure(f"{path}: the text is UTF-16; save it as UTF-8")
    if b"\0" in content:
        raise failure(f"{path}: no text (it has bytes of zero); give {wanted}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise failure(
            f"{path}: line {line} has the byte 0x{content[error.start]:02x}, which is no UTF-8: no text, or one of "
            f"another encoding (Latin-1, Windows); save it as UTF-8, or give {wanted}"
        ) from None
