#!/usr/bin/env python3
"""Builds the static site of the documentation, and checks its links.

Usage: doc_site.py FOLDER

Every Markdown page that git knows becomes an HTML page in FOLDER; a file or folder that a page links to becomes a page that shows
it. A link to a file or heading that does not exist, and a page that no other page links to, are errors.
"""
import html
import html.parser
import pathlib
import posixpath
import re
import shutil
import subprocess
import sys
from urllib.parse import unquote

ROOT = pathlib.Path(__file__).resolve().parents[1]

# The side bar: headings, with pages in reading order. Pages that are not named here are under the last heading.
CONTENTS = {
    "Begin": ["README.md", "docs/tutorial.md", "docs/install.md", "docs/python.md"],
    "Use": ["docs/your-robot.md", "docs/robots.md", "docs/calibrate.md", "docs/cameras.md", "docs/vision.md", "docs/vision-association.md", "docs/vision-accuracy.md", "docs/real-images.md",
            "docs/view.md", "docs/operation.md", "docs/safety.md", "docs/keys.md", "docs/import.md", "docs/replay.md"],
    "Look up": ["docs/configuration.md", "docs/messages.md", "docs/programs/README.md", "docs/notation.md", "docs/architecture.md"],
    "Research": ["docs/guarantees.md", "docs/results.md", "docs/results-protocols.md", "docs/study.md", "docs/equations.md",
                 "docs/benchmarks.md", "docs/numbers.md", "docs/comparison.md"],
    "Folders": [],
}
API = "api/index.html"  # by Doxygen, if it is there
PAGE_SOURCES = {".svg", ".png", ".jpg", ".webp"}  # copied as they are
MAX_SHOWN_BYTES = 300_000

STYLE = """
:root { color-scheme: light dark; --line: #8884; --quiet: #8882 }
* { box-sizing: border-box }
body { margin: 0; font: 16px/1.5 system-ui, sans-serif; display: flex; min-height: 100vh }
nav { flex: 0 0 15rem; padding: 1rem; border-right: 1px solid var(--line); font-size: .9rem; position: sticky; top: 0; height: 100vh; overflow-y: auto }
nav b { display: block; margin-top: .8rem } nav a { display: block; text-decoration: none; padding: .1rem 0 } nav a[aria-current] { font-weight: 600 }
main { flex: 1; min-width: 0; max-width: 62rem; padding: 1rem 2rem 4rem }
pre { background: var(--quiet); padding: .7rem; overflow-x: auto; line-height: 1.35 } code { font-size: .875em }
:not(pre) > code { background: var(--quiet); padding: .1em .25em; border-radius: 3px }
table { border-collapse: collapse; display: block; overflow-x: auto } th, td { border: 1px solid var(--line); padding: .25rem .5rem; text-align: left; vertical-align: top }
img { max-width: 100%; background: #fff } h2, h3, h4 { scroll-margin-top: .5rem } h2 a, h3 a, h4 a { color: inherit; text-decoration: none }
@media (max-width: 60rem) { body { display: block } nav { position: static; height: auto; border: 0 } main { padding: 1rem } }
"""


def project_files(root):
    """All files but those that git ignores."""
    done = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=root, capture_output=True, text=True, check=True)
    return sorted(name for name in set(done.stdout.splitlines()) if (root / name).is_file())


def slug(heading, used):
    """The anchor of a heading, as GitHub makes it; `used` counts those of the page."""
    name = re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
    used[name] = used.get(name, -1) + 1
    return name if used[name] == 0 else f"{name}-{used[name]}"


class Page(html.parser.HTMLParser):
    """The HTML of one Markdown page with anchors at its headings, and its links, which finish() replaces."""

    def __init__(self, root, path):
        super().__init__(convert_charrefs=False)
        self.path = path
        self.parts = []     # strings; (attribute, target) where a link stands
        self.links = []     # targets, as the page gives them
        self.anchors = {}   # anchor -> heading
        self.title = ""
        self._heading = None  # (level, place of its start in parts, its text so far)
        self._used = {}
        # The HTML that pages may use: anchors, and comments.
        source = re.sub(r'<a id="([\w-]+)"></a>', "\ue000\\1\ue001", (root / path).read_text())
        source = re.sub(r"^<!--.*?-->\n", "", source, flags=re.MULTILINE | re.DOTALL)
        done = subprocess.run(["cmark-gfm", "-e", "table", "-e", "strikethrough"], input=source, capture_output=True, text=True, check=True)
        if "<!-- raw HTML omitted -->" in done.stdout:
            raise ValueError(f"{path}: raw HTML in the page; put names in <> into `code`")
        self.feed(done.stdout)
        self.close()

    def handle_starttag(self, tag, attrs):
        if re.fullmatch("h[1-6]", tag):
            self._heading = [int(tag[1]), len(self.parts), ""]
            self.parts.append("")
            return
        self.parts.append("<" + tag)
        for name, value in attrs:
            if name in ("href", "src"):
                self.links.append(value)
                self.parts += [f' {name}="', (value,), '"']
            else:
                self.parts.append(f' {name}="{html.escape(value or "")}"')
        self.parts.append(">")

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)

    def handle_endtag(self, tag):
        if self._heading and tag == f"h{self._heading[0]}":
            level, place, text = self._heading
            anchor = slug(text, self._used)
            self.anchors[anchor] = text
            self.title = self.title or text
            self.parts[place] = f'<h{level} id="{html.escape(anchor)}">'
            self._heading = None
        self.parts.append(f"</{tag}>")

    def handle_data(self, data):
        if self._heading:
            self._heading[2] += data
        self.anchors.update((name, "") for name in re.findall("\ue000(.*?)\ue001", data))
        self.parts.append(re.sub("\ue000(.*?)\ue001", r'<a id="\1"></a>', data))

    def handle_entityref(self, name):
        self.handle_text_reference(f"&{name};")

    def handle_charref(self, name):
        self.handle_text_reference(f"&#{name};")

    def handle_text_reference(self, reference):
        if self._heading:
            self._heading[2] += html.unescape(reference)
        self.parts.append(reference)

    def body(self, resolve):
        return "".join(resolve(part[0]) if isinstance(part, tuple) else part for part in self.parts)


class Site:
    def __init__(self, root, contents):
        files = project_files(root)
        self.root = root
        self.contents = contents
        self.files = set(files)
        self.folders = {folder.as_posix() for name in files for folder in pathlib.PurePosixPath(name).parents} - {"."}
        self.pages = {name: Page(root, name) for name in files if name.endswith(".md")}
        self.errors = []
        self.shown = set()  # files and folders, other than pages, that a page links to

    def target_of(self, page, link):
        """The file or folder and the anchor that a link of a page leads to; None for addresses elsewhere. Records what is wrong."""
        if re.match(r"[a-z]+:", link):
            return None
        path, _, anchor = unquote(link).partition("#")
        path = posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page
        if path in self.folders and path + "/README.md" in self.pages:
            path += "/README.md"
        if path not in self.files and path not in self.folders:
            self.errors.append(f"{page}: link to '{link}', but there is no file {path}")
        elif anchor and (path not in self.pages or anchor not in self.pages[path].anchors):
            self.errors.append(f"{page}: link to '{link}', but {path} has no heading with this anchor")
        return path, anchor

    def check(self):
        linked = {"README.md"}
        for name, page in self.pages.items():
            for link in page.links:
                target = self.target_of(name, link)
                if target and target[0] != name:
                    linked.add(target[0])
                    if target[0] not in self.pages:
                        self.shown.add(target[0])
        self.errors += [f"{name}: no page links to this page" for name in sorted(set(self.pages) - linked)]
        known = {name for names in self.contents.values() for name in names}
        self.errors += [f"tools/doc_site.py: {name} is in the side bar, but there is no such page" for name in sorted(known - set(self.pages))]
        return self.errors

    @staticmethod
    def address(path):
        """Where a file, folder or page of the project is in the site."""
        if path == "README.md":
            return "index.html"
        if path.endswith("/README.md"):
            return path.removesuffix("README.md") + "index.html"
        if path.endswith(".md"):
            return path.removesuffix(".md") + ".html"
        return path if pathlib.PurePosixPath(path).suffix in PAGE_SOURCES else path + ".html"

    def navigation(self, address, with_api):
        named = {name for names in self.contents.values() for name in names}
        rest = [name for name in sorted(self.pages) if name not in named]
        for heading, names in self.contents.items():
            yield f"<b>{heading}</b>"
            for name in names or [n for n in rest if not n.startswith(("docs/programs/", "docs/results/"))]:
                title = name.removesuffix("/README.md") if heading == "Folders" else self.pages[name].title
                current = ' aria-current="page"' if self.address(name) == address else ""
                yield f'<a href="{relative(self.address(name), address)}"{current}>{html.escape(title)}</a>'
            if heading == "Look up" and with_api:
                yield f'<a href="{relative(API, address)}">C++ headers</a>'

    def write(self, folder):
        with_api = (folder / API).exists()

        def emit(path, title, body):
            address = self.address(path)
            file = folder / address
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
                            f'<title>{html.escape(title)}</title><link rel="stylesheet" href="{relative("style.css", address)}"></head>\n'
                            f'<body><nav>{"".join(self.navigation(address, with_api))}</nav>\n<main>\n{body}</main></body></html>\n')

        folder.mkdir(parents=True, exist_ok=True)
        (folder / "style.css").write_text(STYLE.lstrip())
        for name, page in self.pages.items():
            def resolve(link, name=name):
                target = self.target_of(name, link)
                if target is None:
                    return html.escape(link)
                return html.escape(relative(self.address(target[0]), self.address(name)) + (f"#{target[1]}" if target[1] else ""))
            emit(name, f"{page.title} · multireach", page.body(resolve))
        for name in sorted(self.shown):
            source = self.root / name
            if source.is_dir():
                children = "".join(f"<li><code>{html.escape(file.removeprefix(name + '/'))}</code></li>"
                                   for file in sorted(self.files) if file.startswith(name + "/"))
                emit(name, name, f"<h1>{html.escape(name)}</h1><ul>{children}</ul>\n")
            elif source.suffix in PAGE_SOURCES:
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, folder / name)
            else:
                emit(name, name, f"<h1>{html.escape(name)}</h1>{shown_text(source)}\n")


def shown_text(source):
    data = source.read_bytes()
    if len(data) > MAX_SHOWN_BYTES or b"\0" in data:
        return f"<p>{len(data)} bytes, not shown.</p>"
    return f"<pre><code>{html.escape(data.decode(errors='replace'))}</code></pre>"


def relative(address, page):
    return posixpath.relpath(address, posixpath.dirname(page) or ".")


def main(arguments):
    if len(arguments) != 1 or arguments[0] in ("--help", "-h"):
        print(__doc__)
        return 0 if arguments in (["--help"], ["-h"]) else 2
    try:
        site = Site(ROOT, CONTENTS)
    except ValueError as error:
        print(f"doc_site.py: {error}", file=sys.stderr)
        return 1
    errors = site.check()
    for error in errors:
        print(f"doc_site.py: {error}", file=sys.stderr)
    if errors:
        return 1
    site.write(pathlib.Path(arguments[0]))
    links = sum(len(page.links) for page in site.pages.values())
    print(f"{len(site.pages)} pages, {links} links: {arguments[0]}/index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
