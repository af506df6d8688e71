"""The documentation as a site: it is built without a warning, its notebook runs, and its pages load nothing from elsewhere."""

import re
import subprocess
import sys

import gymnasium as gym
import pytest
from conftest import ROOT

import dragnet

GALLERY = ROOT / "docs/figures/gallery"


@pytest.fixture(scope="module")
def site(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert (built.returncode, built.stdout + built.stderr) == (0, "")
    return folder


def test_every_guide_is_a_page(site):
    guides = {path.stem for path in (ROOT / "docs").glob("*.md")} | {"architecture", "changelog", "scale", "scenarios"}
    assert guides < {path.parent.name for path in site.glob("*/index.html")}
    assert "Two commands" in (site / "index.html").read_text()


def test_links_of_the_repository_lead_to_pages_and_sources_have_none(site):
    assert 'href="../scenarios/#' in (site / "guide/index.html").read_text()
    assert 'href="../maps/#subjects-of-known-number"' in (site / "scenarios/index.html").read_text()
    assert 'href="field-guide/#ros-2"' in (site / "index.html").read_text()
    for page in site.glob("**/*.html"):
        links = re.findall(r'href="([^"]*)"', page.read_text())
        assert not [link for link in links if link.endswith((".md", ".rs", ".toml"))], page


def test_pages_load_nothing_from_elsewhere(site):
    loads = re.compile(r'<(?!a )[^>]*(?:src|href)="(?:https?:)?//[^"]*|url\((?:["\']?)(?:https?:)?//[^)]*|@import[^;]*')
    count = 0
    for path in [*site.glob("**/*.html"), *site.glob("**/*.css")]:
        assert not loads.findall(path.read_text()), path
        count += 1
    assert count > 20


def test_the_notebook_shows_what_its_cells_have_put_out(site):
    page = (site / "notebook/index.html").read_text()
    assert "% of the objects found on" in re.sub(r"<[^>]*>", "", page)
    assert page.count('src="data:image/png;base64,') == 3
    assert page.count('class="dataframe"') == 4
    # Without outputs, which would be those of another version.
    assert '"outputs": []' in (ROOT / "docs/notebook.ipynb").read_text()
    assert "image/png" not in (ROOT / "docs/notebook.ipynb").read_text()


def test_the_api_has_every_name_of_the_package(site):
    page = (site / "api/index.html").read_text()
    for name in set(dragnet.__all__) - {"OFFSETS", "__version__"}:
        assert f'id="dragnet.{name}"' in page, name
    assert ":meth:" not in page
    # A comment above an attribute, and a method that environments share.
    assert "Edge of a cell, meters." in page
    assert 'id="dragnet.SearchEnv.clone"' in page


def test_the_gallery_has_a_small_picture_of_each_environment():
    registered = {spec.name for spec in gym.registry.values() if spec.namespace == "dragnet"}
    files = list(GALLERY.glob("*"))
    assert {path.name for path in files} == {f"{name}.png" for name in registered - {"Search"}}
    page = (ROOT / "docs/gallery.md").read_text()
    for path in files:
        assert path.stat().st_size < 30_000
        assert f"(figures/gallery/{path.name})" in page
