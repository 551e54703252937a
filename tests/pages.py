"""Reads the pages of `aeb-sumo report` in tests."""

from html.parser import HTMLParser

_VOID = {"meta", "link", "br", "hr", "img", "input", "wbr"}


class Page(HTMLParser):
    """What a page is made of; raises AssertionError where elements do not nest."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.ids: list[str] = []
        self.numbers: dict[str, float] = {}  # key -> value
        self.bounds: dict[str, tuple[float, float]] = {}  # key -> low, high
        self.shown: dict[str, str] = {}  # key -> as it is shown
        self.n: dict[str, float] = {}  # key -> what it rests on
        self.drawings: list[dict[str, str | None]] = []  # attributes of each svg
        self.figures: list[dict[str, str]] = []  # title and texts of each figure
        self.links: list[str] = []  # all that could be fetched or jumped to
        self.text: list[str] = []
        self._open: list[str] = []
        self._key = ""
        self.feed(text)
        self.close()
        assert not self._open, f"never closed: {self._open}"

    def handle_starttag(self, tag, attrs):
        self._note(tag, dict(attrs))
        if tag not in _VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self._note(tag, dict(attrs))

    def handle_endtag(self, tag):
        assert self._open, f"</{tag}> closes nothing"
        assert self._open[-1] == tag, f"</{tag}> closes <{self._open[-1]}>"
        self._open.pop()
        self._key = ""

    def handle_data(self, data):
        if "style" not in self._open:
            self.text.append(data)
        if self._key:
            self.shown[self._key] = data.strip()
        if "figure" in self._open and self._open[-1] in {"h3", "figcaption", "text", "tspan"}:
            kind = "drawn" if self._open[-1] in {"text", "tspan"} else self._open[-1]
            self.figures[-1][kind] = f"{self.figures[-1].get(kind, '')} {data.strip()}".strip()

    def _note(self, tag, attrs):
        if "id" in attrs:
            self.ids.append(attrs["id"])
        if tag == "data":
            key = self._key = attrs["data-key"]
            assert key not in self.numbers, f"{key} stands there twice"
            self.numbers[key] = float(attrs["value"])
            self.bounds[key] = float(attrs["data-low"]), float(attrs["data-high"])
            self.n[key] = float(attrs["data-n"])
        if tag == "svg":
            self.drawings.append(attrs)
        if tag == "figure":
            self.figures.append({})
        self.links += [str(attrs[name]) for name in ("href", "src", "xlink:href", "action") if name in attrs]
        self.links += [str(value) for value in attrs.values() if "://" in str(value)]
