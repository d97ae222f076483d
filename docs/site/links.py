"""Hook of MkDocs: pages of the repository's root on the site, links that leave the documentation, formulas."""

import os
import re
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[2]
PAGES = {"architecture.md": "ARCHITECTURE.md", "changelog.md": "CHANGELOG.md", "contributing.md": "CONTRIBUTING.md"}
# where the files are that the site does not have; unknown outside of the workflow, then their names stand alone
REPOSITORY = os.environ.get("GITHUB_REPOSITORY")
# formulas are MathML, which browsers draw without any script
FORMULA = re.compile(r"\$\$(.+?)\$\$|(?<![\w$\\])\$([^\s$`](?:[^$`\n]*[^\s$`])?)\$(?![\w$])", flags=re.DOTALL)
FENCED = re.compile(r"(^ *```.*?^ *```)", flags=re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"(`[^`\n]+`)")
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\((?!https?:|#|mailto:)([^)\s]+)\)")


def on_config(config):
    """Show the repository on every page, where it is known."""
    if REPOSITORY:
        config.repo_url = f"https://github.com/{REPOSITORY}"
        config.repo_name = REPOSITORY
    return config


def on_files(files, config):
    """Add the pages of the repository's root."""
    for name, source in PAGES.items():
        text = (ROOT / source).read_text().replace("](docs/", "](").replace("](#unreleased)", "](#)")
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown, page, config, files):
    """Lead links to files that are not on the site to the repository."""
    folder = Path(page.file.src_uri).parent

    def lead(found):
        text, target = found.groups()
        path, hash_sign, section = target.partition("#")
        inside = os.path.normpath(folder / path)
        if not inside.startswith("..") and files.get_file_from_path(inside) is not None:
            return found[0]
        outside = os.path.normpath(Path("docs") / folder / path)
        outside = outside if (ROOT / outside).exists() else os.path.normpath(inside)
        for name, source in PAGES.items():
            if outside == source:
                up = "../" * len(folder.parts)
                return f"[{text}]({up}{name}{hash_sign}{section})"
        if not (ROOT / outside).exists():
            return found[0]  # MkDocs says what is wrong with it
        return f"[{text}](https://github.com/{REPOSITORY}/blob/main/{outside})" if REPOSITORY else text

    # code stays as it is, but for words that only the tests read
    parts = FENCED.split(markdown)
    parts[1::2] = [re.sub(r"^( *```\w+) no-test", r"\1", part) for part in parts[1::2]]
    parts[0::2] = [prose(part, folder.name == "reference", lead) for part in parts[0::2]]
    return "".join(parts)


def prose(text, is_reference, lead):
    """Return text without fenced code, with formulas and links made for the site."""
    parts = INLINE.split(text)
    parts[0::2] = [FORMULA.sub(formula, part) for part in parts[0::2]]
    if is_reference:
        parts[0::2] = [re.sub(r"\]( ?)\[", r"]\1&#91;", part) for part in parts[0::2]]  # [C][M] are marks, no links
    return LINK.sub(lead, "".join(parts))


def formula(found):
    """Return a formula as MathML."""
    block, inline = found.groups()
    return convert(block or inline, display="block" if block else "inline")
