"""Report private or vague words in the texts of the project, with the field's word for each.

It reads documents, docstrings, comments, messages and the names of tests. ``prose.toml`` has the
words. A comment ``prose: <reason>``, of two words or more, excuses its line.
"""

import argparse
import io
import re
import subprocess
import sys
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RULES = tomllib.loads((ROOT / "tools" / "prose.toml").read_text(encoding="utf-8"))
EXCUSE = re.compile(r"prose: (?=\w+ \w+)")
CODE = re.compile(r"``.+?``|`[^`]+`|\$[^$]+\$|\{[^{}]*\}|https?://\S+|\]\([^)]*\)")
NATIVE = re.compile(r'//.*|/\*.*|^\s*\*.*|"(?:\\.|[^"\\])* (?:\\.|[^"\\])*"')
LAYOUT = (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.COMMENT, tokenize.ENCODING)
Text = tuple[int, str, bool]  # number of the line, text, and True for the summary of a docstring


def python_texts(source: str) -> Iterator[Text]:
    """Yield comments, docstrings, other strings that hold a space, and names of tests."""
    is_first, before = True, ""
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        kind, text, line = token.type, token.string, token.start[0]
        if kind == tokenize.COMMENT:
            yield line, text.lstrip("#: "), False
        elif before == "def" and text.startswith("test_"):
            yield line, text.replace("_", " "), False
        elif tokenize.tok_name[kind] in ("STRING", "FSTRING_MIDDLE") and " " in text:
            for offset, part in enumerate(text.split("\n")):
                yield line + offset, part.strip("rbf\"' "), is_first and offset == 0
        if kind != tokenize.NL:
            is_first, before = kind in LAYOUT, text


def document_texts(source: str) -> Iterator[Text]:
    """Yield the lines of a document outside its blocks of code."""
    fenced = False
    for line, text in enumerate(source.splitlines(), start=1):
        fenced ^= text.lstrip().startswith("```")
        if not fenced:
            yield line, text, False


def texts(path: Path, source: str) -> Iterator[Text]:
    """Yield what a file has for readers."""
    if path.suffix in (".py", ".pyi"):
        yield from python_texts(source)
    elif path.suffix in (".md", ".rst"):
        yield from document_texts(source)
    else:
        comment = re.compile("#.*") if path.suffix in (".sh", ".toml", ".yml") else NATIVE
        for line, text in enumerate(source.splitlines(), start=1):
            yield from ((line, found.strip('/*"# '), False) for found in comment.findall(text))


def complaints(path: Path) -> Iterator[tuple[int, str, str]]:
    """Yield the number of the line, what was found and a better word, for each place in a file."""
    source = (ROOT / path).read_text(encoding="utf-8")
    excused = [EXCUSE.search(line) for line in source.split("\n")]
    for line, text, is_summary in texts(path, source):
        rules = RULES["words"] | (RULES["summaries"] if is_summary else {})
        for pattern, better in rules.items() if not excused[line - 1] else ():
            for found in re.finditer(pattern, CODE.sub("`", text), re.IGNORECASE):
                yield line, found.group().strip(), better


def main() -> int:
    """Print what was found; the exit status is 1 if anything was."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", help="below the checkout; default: all of them")
    parser.add_argument("--count", action="store_true", help="print a table by folder")
    options = parser.parse_args()
    git = ["git", "-C", str(ROOT), "ls-files", "-co", "--exclude-standard"]
    listed = subprocess.run(git, capture_output=True, text=True, check=True).stdout.splitlines()
    counts: dict[str, Counter[str]] = {}
    for path in map(Path, options.files or listed):
        if path.suffix in RULES["suffixes"] and not re.match(RULES["left_out"], path.as_posix()):
            for line, found, better in complaints(path):
                counts.setdefault(path.parts[0], Counter())[better] += 1
                if not options.count:
                    print(f"{path}:{line}: {found!r}: {better}")
    if options.count:
        print("| better |", *(f"{name} |" for name in counts))
        for better in sorted(set().union(*counts.values())):
            print(f"| {better} |", *(f"{folder[better]} |" for folder in counts.values()))
    total = sum(folder.total() for folder in counts.values())
    print(f"{total} places to reword", file=sys.stderr)
    return bool(counts)


if __name__ == "__main__":
    sys.exit(main())
