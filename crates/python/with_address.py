"""Fills in where the project lives: links and pictures of the page of the index, and the addresses in pyproject.toml.

`python3 with_address.py https://github.com/OWNER/REPOSITORY [FOLDER]` changes crates/python/README.md and pyproject.toml in the
folder (the repository, unless one is given), as a workflow does in its own checkout. The repository itself does not know where
it lies, and says nothing that may be wrong.
"""

import pathlib
import re
import sys


def described(text: str, address: str) -> str:
    """The page with its links to files of the repository made absolute."""

    def absolute(match: re.Match) -> str:
        mark, words, target = match.groups()
        if "://" in target or target.startswith("#"):
            return match.group(0)
        return f"{mark}[{words}]({address}/{'raw' if mark else 'blob'}/HEAD/{target.removeprefix('../../')})"

    return re.sub(r"(!?)\[([^\]]*)\]\(([^)]*)\)", absolute, text)


def addressed(text: str, address: str) -> str:
    """pyproject.toml with the addresses of the project."""
    urls = {
        "Homepage": address,
        "Documentation": f"{address}/blob/HEAD/docs/README.md",
        "Changelog": f"{address}/blob/HEAD/CHANGELOG.md",
        "Issues": f"{address}/issues",
        "Source": address,
    }
    table = "".join(f'{name} = "{url}"\n' for name, url in urls.items())
    return text.replace("[project.scripts]", f"[project.urls]\n{table}\n[project.scripts]", 1)


def main(address: str, folder: str | None = None) -> None:
    root = pathlib.Path(folder) if folder else pathlib.Path(__file__).resolve().parents[2]
    address = address.removesuffix(".git").rstrip("/")
    for name, change in [("crates/python/README.md", described), ("pyproject.toml", addressed)]:
        path = root / name
        path.write_text(change(path.read_text(encoding="utf-8"), address), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
