"""What a page holds, read back without a browser."""

import base64
import gzip
from html.parser import HTMLParser


class Elements(HTMLParser):
    """Tags with their attributes, and the texts of scripts by their id."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.scripts, self._script = [], {}, None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._script = dict(attrs).get("id", "code") if tag == "script" else None

    def handle_endtag(self, tag):
        if tag == "script":
            self._script = None

    def handle_data(self, data):
        if self._script is not None:
            self.scripts[self._script] = self.scripts.get(self._script, "") + data


def unpacked(text, name):
    """What a compressed script element of a page holds."""
    return gzip.decompress(base64.b85decode(Elements(text).scripts[name].replace(",", "<")))
