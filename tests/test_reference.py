"""Citations of docs/reference lead to sections that are there."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = {page.name: page for page in sorted((ROOT / "docs/reference").glob("*.md"))}
# what takes a citation from one line of a comment to the next
GAP = r"(?:[ \t]+|[ \t]*\n[ \t]*(?:\*[ \t]|//[ \t]|\#[ \t])?[ \t]*)"
SECTION = r"#\d+(?:\.\w+)*"
CITATION = re.compile(
    rf"docs/reference/([\w-]+\.md)((?:{SECTION})?(?:,?{GAP}(?:and{GAP}|to{GAP})?{SECTION})*)", flags=re.MULTILINE
)


def citations(text):
    """Return what a text cites, as pairs of page and section; the section is empty where the whole page is meant."""
    return [
        (page, section)
        for page, sections in CITATION.findall(text)
        for section in (re.findall(r"#([\w.]+)", sections) or [""])
    ]


def anchors(page):
    return re.findall(r'<a id="([^"]+)"></a>', page.read_text())


def tracked():
    """Return the files that git knows and that are text, with their texts."""
    found = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    if found.returncode:
        pytest.skip("not a git checkout")
    for name in filter(None, found.stdout.split("\0")):
        path = ROOT / name
        if path.is_file() and not path.is_symlink() and path != Path(__file__):
            try:
                yield name, path.read_text(encoding="utf-8")
            except UnicodeDecodeError:
                continue


@pytest.fixture(scope="module")
def texts():
    return dict(tracked())


def test_citations_are_found_in_comments():
    text = "/* docs/reference/a.md#4.4.6, #5\n * and #17.H to #17.J */ docs/reference/c.md#2, 3 Hz, docs/reference/d.md"
    sections = [("a.md", "4.4.6"), ("a.md", "5"), ("a.md", "17.H"), ("a.md", "17.J"), ("c.md", "2"), ("d.md", "")]
    assert citations(text) == sections


def test_every_citation_leads_to_a_section(texts):
    there = {name: {"", *anchors(page)} for name, page in PAGES.items()}
    cited = [(name, *citation) for name, text in texts.items() for citation in citations(text)]
    assert len(cited) > 500
    assert [(name, page, at) for name, page, at in cited if at not in there.get(page, ())] == []


@pytest.mark.parametrize("page", PAGES.values(), ids=lambda page: page.stem)
def test_links_lead_somewhere(page):
    for target, section in re.findall(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]*))?\)", page.read_text()):
        aim = page.parent / target if target else page
        assert aim.exists(), target
        assert not section or section in anchors(aim), f"{target}#{section}"


@pytest.mark.parametrize("page", PAGES.values(), ids=lambda page: page.stem)
def test_every_numbered_heading_has_its_own_anchor(page):
    found = anchors(page)
    assert len(found) == len(set(found))
    headings = re.findall(r"^(.*)\n#{2,5} (\d+(?:\.\d+)*)\.? ", page.read_text(), flags=re.MULTILINE)
    assert [number for before, number in headings if before != f'<a id="{number}"></a>'] == []


def test_no_source_is_cited_that_is_kept_elsewhere(texts):
    word = "dossi" + "er"
    assert [name for name, text in texts.items() if name != "CHANGELOG.md" and word in text.lower()] == []
