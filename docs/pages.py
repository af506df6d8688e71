"""What the site has beside the pages in this folder: pages from elsewhere in the repository, and the notebook, which runs for it.

MkDocs calls the functions `on_*` while it builds: see its manual, "Hooks".
"""

import os
import re
import tempfile
from pathlib import Path

import nbclient
import nbformat
from jupyter_client.manager import AsyncKernelManager
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from pygments.formatters import HtmlFormatter  # type: ignore[import-untyped]

ROOT = Path(__file__).resolve().parents[1]

#: Pages by their sources, from the root of the repository; those in this folder have their own names.
PAGES = {
    "README.md": "index.md",
    "ARCHITECTURE.md": "architecture.md",
    "CHANGELOG.md": "changelog.md",
    "scale/README.md": "scale.md",
    "scenarios/README.md": "scenarios.md",
    "docs/notebook.ipynb": "notebook.md",
}
SOURCES = {page: source for source, page in PAGES.items()}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages from elsewhere."""
    for source, page in PAGES.items():
        path = ROOT / source
        text = run_notebook(path) if path.suffix == ".ipynb" else path.read_text(encoding="utf-8")
        files.append(File.generated(config, page, content=text))
    files.append(File.generated(config, "css/code.css", content=colors_of_code()))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Leads links, which are those of the repository, to pages of the site. What is no part of it, such as a source, is named
    without a link."""
    source = Path(SOURCES.get(page.file.src_uri, f"docs/{page.file.src_uri}"))

    def led(link: re.Match[str]) -> str:
        text, address = link.groups()
        if ":" in address or address.startswith("#"):
            return link[0]
        path, hash_sign, anchor = address.partition("#")
        target = os.path.normpath(source.parent / path)
        there = PAGES.get(target, target.removeprefix("docs/"))
        if not (ROOT / target).exists() or files.get_file_from_path(there):
            # Of what there is not MkDocs warns.
            return f"{text}({there}{hash_sign}{anchor})"
        return text.lstrip("!")[1:-1]

    return re.sub(r"(!?\[[^]]*\])\(([^)\s]+)\)", led, markdown)


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Docstrings name things by Sphinx's roles, which are no Markdown."""
    return re.sub(r":(?:attr|class|func|meth|mod):(<code>)", r"\1", html)


def run_notebook(path: Path) -> str:
    """A notebook as Markdown, with the output of its cells as they run now; an error of a cell ends the build."""
    program = Path(os.environ.get("DRAGNET", ROOT / "target/debug/dragnet")).resolve()
    os.environ["PATH"] = os.pathsep.join([str(program.parent), os.environ["PATH"]])
    notebook = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    with tempfile.TemporaryDirectory() as folder:
        # By sockets in the file system: it warns of others, which any user of the computer could read.
        kernel = AsyncKernelManager(transport="ipc", ip=str(Path(folder) / "kernel"))
        client = nbclient.NotebookClient(notebook, kernel, timeout=120, resources={"metadata": {"path": folder}})
        client.execute(cleanup_kc=True)
    parts = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
        else:
            parts += [f"```python\n{cell.source}\n```", *map(as_markdown, cell.outputs)]
    return "\n\n".join(parts)


def as_markdown(output: nbformat.NotebookNode) -> str:
    """What a cell has put out: its text, picture or table."""
    if output.output_type == "stream":
        return f"```text\n{output.text.rstrip()}\n```"
    data = output.data
    if "image/png" in data:
        return f"![Picture of the cell above](data:image/png;base64,{data['image/png'].replace(chr(10), '')})"
    if "text/html" in data:
        # Its style is the site's.
        table = re.sub(r"<style.*?</style>|\n\s*", "", data["text/html"], flags=re.DOTALL)
        return f'<div class="table-of-cell">{table}</div>'
    return f"```text\n{data['text/plain']}\n```"


def colors_of_code() -> str:
    """Style sheet of code, for both color modes of the theme."""
    styles = {"light": "default", "dark": "github-dark"}
    return "\n".join(
        HtmlFormatter(style=style).get_style_defs(f"[data-bs-theme={mode}] .highlight")
        for mode, style in styles.items()
    )
